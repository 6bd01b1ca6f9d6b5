import msgspec

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.facts.domain import FieldSpec
from wakeful.facts.events import Context, Relation
from wakeful.testing import ScriptedMind
from wakeful.treatments.description import Description, description


def described(*episodes: object, **about: object) -> Description:
    result = ScriptedMind(DOMAIN, "auto", script(*episodes)).run(description, event(**about))  # type: ignore[arg-type]
    assert isinstance(result, Description)
    return result


def test_the_scene_entry_holds_what_it_is_where_and_how_it_stands_to_memory() -> None:
    scene = described(relation=Relation.MOVED, context=Context(zone="hall", task="tidy up"), load=0.5).scene
    assert (scene.entity, scene.kind, scene.relation, scene.zone, scene.task) == (
        "J3",
        "current_high",
        "moved",
        "hall",
        "tidy up",
    )


def test_normal_is_what_its_own_sightings_were_like() -> None:
    seen = [episode(f"e{at}", 60.0 * (at + 1), load=0.2 + 0.01 * at, state="normal") for at in range(5)]
    result = described(*seen, load=0.9, state="normal")
    load, state = result.scene.attributes
    assert (load.usual, load.as_usual) == (0.22, False)
    assert (state.usual, state.as_usual) == ("normal", True)
    assert "unusual: load 0.9 (usually 0.22)" in result.says
    assert result.would_change == ("load 0.22, as usual",)


def test_a_number_inside_the_range_that_was_seen_is_as_usual() -> None:
    seen = [episode(f"e{at}", 60.0 * (at + 1), load=value) for at, value in enumerate((0.1, 0.9))]
    assert described(*seen, load=0.5).scene.attributes[0].as_usual is True


def test_something_new_is_compared_with_like_cases() -> None:
    like = [episode(f"e{at}", 60.0, entity=f"J{at}", likeness=0.8, load=0.2) for at in range(3)]
    scene = described(*like, relation=Relation.NEW, load=0.2).scene
    assert (scene.sightings, scene.usual_of) == (3, "like cases")


def test_what_registration_said_is_not_said_twice() -> None:
    result = described(says="current 2.3 A, usually 1.1 A", value=2.3)
    assert result.says == "J3: changed; nothing like it is remembered."


def test_what_a_field_means_is_no_statement_about_the_event() -> None:
    domain = msgspec.structs.replace(DOMAIN, fields={"airborne": FieldSpec(meaning="in the air")})
    result = ScriptedMind(domain, "auto", script()).run(description, event(airborne=False))
    assert b"in the air" not in msgspec.json.encode(result)
    assert "value" not in result.says


def test_with_nothing_to_compare_with_it_is_sure_of_half() -> None:
    assert described(load=0.5).confidence == 0.5
    assert described().confidence == 0.1

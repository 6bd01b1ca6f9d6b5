from importlib.metadata import EntryPoint

import pytest

from tests.treatments.worlds import DOMAIN, event, script
from wakeful.contracts.treatment import Mind
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.testing import check_treatment
from wakeful.treatments.decorator import FunctionTreatment, TreatmentError, treatment
from wakeful.treatments.description import description
from wakeful.treatments.registry import BUILT_IN, GROUP, Registry


class Greeting(Result, frozen=True, kw_only=True, tag="greeting"):
    whom: str


@treatment()
async def greeting(event: Event, mind: Mind) -> Greeting:
    """Greets whatever is new."""
    await mind.work()
    return Greeting(
        says=f"hello, {event.entity}", confidence=1.0, rests_on=(event.id,), would_change=("it leaves",), whom=event.entity
    )


not_a_treatment = 7


def point(name: str, value: str) -> EntryPoint:
    return EntryPoint(name=name, value=value, group=GROUP)


def test_the_built_in_treatments_have_names_types_and_tags_of_their_own() -> None:
    assert [each.name for each in BUILT_IN] == list(Registry(installed=()).names())
    assert len({each.result for each in BUILT_IN}) == len(BUILT_IN) == 8
    for each in BUILT_IN:
        assert each.result.__struct_config__.tag == each.name


def test_a_users_own_treatment_keeps_the_contract_and_is_found_by_name() -> None:
    check_treatment(greeting, event(), DOMAIN, script(), auto_steps=1)
    registry = Registry(own=[greeting], installed=())
    assert registry.get("greeting") is greeting
    assert registry.names()[-1] == "greeting"


def test_an_installed_treatment_is_found_through_its_entry_point() -> None:
    registry = Registry(installed=[point("anything", f"{__name__}:greeting")])
    assert registry.get("greeting").says == "Greets whatever is new."


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("no_such_module_anywhere:it", "does not load"),
        (f"{__name__}:nothing", "does not load"),
        (f"{__name__}:not_a_treatment", "is no treatment"),
        (f"{__name__}:Greeting", "is a class"),
        ("wakeful.treatments.description:description", "the name is taken"),
    ],
)
def test_a_broken_entry_point_is_named_with_its_reason_and_takes_nothing_else_with_it(value: str, why: str) -> None:
    registry = Registry(installed=[point("theirs", value), point("ours", f"{__name__}:greeting")])
    assert why in registry.broken["theirs"]
    assert "greeting" in registry.names()
    with pytest.raises(TreatmentError, match=r"no treatment 'theirs' \(its entry point is broken"):
        registry.get("theirs")


def test_an_unknown_name_is_answered_with_the_known_ones() -> None:
    with pytest.raises(TreatmentError, match="no treatment 'divination'; there are description, memory"):
        Registry(installed=()).get("divination")


def test_a_taken_name_is_only_replaced_on_purpose() -> None:
    @treatment("description", result=Greeting, says="another")
    async def another(event: Event, mind: Mind) -> Greeting:
        return await greeting.treat(event, mind)  # type: ignore[return-value]

    registry = Registry(installed=())
    with pytest.raises(TreatmentError, match="pass replace=True"):
        registry.add(another)
    assert registry.get("description") is description
    registry.add(another, replace=True)
    assert registry.get("description") is another
    assert Registry(installed=()).get("description") is description


async def _silent(event: Event, mind: Mind) -> Greeting:
    return await greeting.treat(event, mind)  # type: ignore[return-value]


async def _untyped(event: Event, mind: Mind):  # type: ignore[no-untyped-def]
    """Says nothing of its type."""


async def _alone(event: Event) -> Greeting:  # type: ignore[empty-body]
    """Has no mind."""


def _plain(event: Event, mind: Mind) -> Greeting:  # type: ignore[empty-body]
    """Is no coroutine."""


@pytest.mark.parametrize(
    ("function", "name", "version", "why"),
    [
        (_silent, "silent", 1, "give says="),
        (_untyped, "untyped", 1, "give result="),
        (_alone, "alone", 1, "async def alone"),
        (_plain, "plain", 1, "async def plain"),
        (_silent, "Not A Name", 1, "small letters"),
        (_silent, "", 1, "small letters|async def"),
    ],
)
def test_what_can_be_no_treatment_is_refused_with_what_to_do(function: object, name: str, version: int, why: str) -> None:
    with pytest.raises(TreatmentError, match=why):
        treatment(name, version=version)(function)  # type: ignore[arg-type]


def test_a_version_below_one_is_refused() -> None:
    with pytest.raises(TreatmentError, match="version 0"):
        treatment("silent", says="x", version=0)(_silent)


def test_a_treatment_can_be_shown() -> None:
    assert isinstance(greeting, FunctionTreatment)
    assert repr(greeting) == "<treatment greeting version 1>"
    assert greeting.result is Greeting

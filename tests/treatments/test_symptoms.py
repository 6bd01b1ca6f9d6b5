import pytest

from tests.treatments.worlds import DOMAIN, episode, event
from wakeful.facts.values import Field
from wakeful.treatments.symptoms import findings, seen_in, told


@pytest.mark.parametrize(
    ("symptom", "value", "shown"),
    [
        ("x=hot", "HOT", True),
        ("x=hot", "cold", False),
        ("x=hot", 3.0, False),
        ("x=3", 3, True),
        ("x=true", True, True),
        ("x=true", 1.0, True),
        ("x=false", 0.0, True),
        ("x=true", "false", False),
        ("x>2", 2.5, True),
        ("x=>2", 2.0, False),
        ("x<=2", 2.0, True),
        ("x>2", "hot", None),
        ("x>two", 3.0, None),
        ("x=hot", None, None),
        ("x>2", float("nan"), None),
        ("x=hot", (1.0,), None),
        ("y=hot", "hot", None),
    ],
)
def test_a_condition_holds_fails_or_is_unknown(symptom: str, value: Field, shown: bool | None) -> None:
    assert seen_in(symptom, event(x=value)) is shown


def test_a_kind_that_was_not_registered_is_no_finding() -> None:
    known = findings(DOMAIN.fault, event("object"), [episode("e", 10.0, kind="stop")])
    assert known == {"stop": True}


def test_context_counts_as_well_as_the_events_own_fields_which_come_first() -> None:
    met = event(state="normal")
    assert seen_in("state=normal", met) is True
    assert seen_in("relation=changed", met) is True


def test_a_word_in_the_events_sentence_is_a_sign_and_its_absence_none() -> None:
    met = event(says="sensors says: no barometer found")
    assert seen_in("says~baro|pressure", met) is True
    assert seen_in("says~compass", met) is None
    assert told("says~baro|pressure", met) == "“baro” in what it says"


def test_a_word_that_a_text_field_lacks_is_a_finding() -> None:
    assert seen_in("text~baro", event(text="all is well")) is False

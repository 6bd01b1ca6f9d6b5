import msgspec
import pytest

from tests.treatments.worlds import DOMAIN, NOW_S, event, script
from wakeful.facts.domain import DomainSpec, EvidenceSource
from wakeful.facts.evidence import Evidence
from wakeful.facts.values import Field
from wakeful.testing import ScriptedMind
from wakeful.treatments.waiting import Askable, about, askable, patience_s, reading


def offered(*channels: str, entity: str = "J3", key: str = "{channel}", **fields: Field) -> list[str]:
    source = EvidenceSource(topic="t", channels=channels, key=key)
    domain = DomainSpec(name="d", version=1, says="d", evidence=(source,))
    return [offer.key for offer in askable(domain, event(entity=entity, **fields))]


@pytest.mark.parametrize(
    ("channels", "fields", "keys"),
    [
        (("row/Current_J*",), {"channel": "row/Current_J5"}, ["row/Current_J5"]),
        (("row/Current_J*",), {}, ["row/Current_J3"]),
        (("row/Temperature_*",), {}, ["row/Temperature_J3"]),
        (("row/Tool_current",), {}, ["row/Tool_current"]),
        (("battery*/remaining",), {}, []),  # which of several batteries, nobody can tell
        (("battery*/remaining",), {"channel": "battery1/remaining"}, ["battery1/remaining"]),
        ((), {}, ["J3"]),
    ],
)
def test_what_can_be_asked_for_is_what_concerns_the_event(
    channels: tuple[str, ...], fields: dict[str, Field], keys: list[str]
) -> None:
    assert offered(*channels, **fields) == keys


def test_a_key_is_filled_in_as_registration_fills_it() -> None:
    assert offered("row/Current_J*", key="{robot}/{topic}/{name}/{number}") == ["robot/row/Current_J3/3"]


def test_an_offer_answers_for_fields_that_its_value_or_channel_names() -> None:
    offer = Askable(topic="t", key="k", every_s=1.0, names=("Tool_current", "tilt_deg"))
    assert about([offer], "current_a") == (offer,)
    assert about([offer], "tilt_deg") == (offer,)
    assert about([offer], "speed_mps") == ()
    assert about([offer], "a") == ()


def test_nobody_waits_past_half_of_what_is_left() -> None:
    mind = ScriptedMind(DOMAIN, "delib", script())
    offer = Askable(topic="t", key="k", every_s=2.0)
    assert patience_s(event(), mind, offer) == 30.0  # half the outcome window of 60 s
    assert patience_s(event(deadline_s=10.0), mind, offer) == 5.0
    assert patience_s(event(deadline_s=3.0), mind, offer) == 0.0  # the next reading could not come in 1.5 s
    assert patience_s(event(at_s=NOW_S - 50.0), mind, offer) == 5.0
    assert patience_s(event(at_s=NOW_S - 600.0), mind, offer) == 0.0


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (b"2.5", 2.5),
        (b'"open"', "open"),
        (b"true", True),
        (b'{"current_a": 3, "value": 9}', 3.0),
        (b'{"mean": 1}', 1.0),
        (b'{"other": 1}', None),
        (b"[1]", None),
        (b"1e999", None),
        (b"not json", None),
        (b"null", None),
    ],
)
def test_evidence_is_read_for_what_it_says_of_a_field(value: bytes, said: Field) -> None:
    assert reading(Evidence(id="e", topic="t", key="k", at_ns=0, value=msgspec.Raw(value)), "current_a") == said

"""What the fault table of px4_ulog says of signs whose meaning is known."""

from __future__ import annotations

import pytest

from tests.treatments.worlds import event
from wakeful.domains import load
from wakeful.facts.values import Field
from wakeful.testing import Script, ScriptedMind
from wakeful.treatments.diagnosis import Diagnosis, diagnosis

DOMAIN = load("px4_ulog").spec
SETTLING = "receiver still finding its place"


def first(kind: str, entity: str = "gps", says: str = "", **fields: Field) -> Diagnosis:
    result = ScriptedMind(DOMAIN, "auto", Script()).run(diagnosis, event(kind, entity, says=says, **fields))
    assert isinstance(result, Diagnosis)
    assert result.suspects[0].explains
    return result


@pytest.mark.parametrize("worse", [False, None])
def test_a_receiver_that_finds_its_satellites_has_no_broken_antenna(worse: bool | None) -> None:
    result = first("gps_fix", fix="3D", satellites=10.0, settled=False, worse=worse)
    antenna = next(each for each in result.suspects if each.fault == "GPS antenna or cable")
    assert result.suspects[0].fault == SETTLING
    assert antenna.posterior < 0.1


def test_a_fix_that_is_lost_after_it_was_good_is_no_settling() -> None:
    result = first("gps_fix", fix="none", satellites=4.0, settled=True, worse=True)
    settling = next(each for each in result.suspects if each.fault == SETTLING)
    assert result.suspects[0].fault == "GPS antenna or cable"
    assert settling.posterior < 0.2


def test_a_check_is_of_what_its_words_name() -> None:
    transmitter = first("check", "remote control", "PX4's check of the remote control fails: No manual control input.")
    assert transmitter.suspects[0].fault == "transmitter off, out of range or not bound"
    assert first("check", "gps", "PX4's check of the gps fails: GPS fix too low.").suspects[0].fault == SETTLING
    missing = first("error_message", "module sensors", "sensors says (error): no barometer found on /dev/baro0")
    assert {each.fault for each in missing.suspects[:2]} == {"sensors missing or not calibrated", "barometer fault"}

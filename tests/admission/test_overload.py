"""What is given up at a load: deliberation first, then what is not critical, criticals last; and through the whole mind."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.overload import virtual
from wakeful.admission.overload import Overload
from wakeful.facts.events import CRITICAL, Event
from wakeful.facts.overload import REFUSED, SHED, UNLIMITED, Load, OverloadSettings
from wakeful.facts.time import Stamp

SETTINGS = OverloadSettings(shed_backlog=10, shed_age_s=5.0, refuse_backlog=100, reserve=0.2, source_share=0.5, most_open=1000)


def event(criticality: int = 0, source: str = "s") -> Event:
    stamp = Stamp(source_ns=0)
    return Event(id="e", kind="k", entity="x", source=source, position=0, stamp=stamp, criticality=criticality)  # type: ignore[arg-type]


def load(backlog: int = 0, of_source: int = 0, oldest_s: float = 0.0, open_: int = 0) -> Load:
    return Load(backlog, of_source, oldest_s, open_)


@pytest.mark.parametrize("at", [load(), load(9, 9, 4.9, 9), load(9, 9, 0.0, 999)])
def test_below_every_limit_nothing_is_given_up(at: Load) -> None:
    overload = Overload(SETTINGS)
    assert overload.objection(event(), at) == ""
    assert overload.sheds(event(), at) == ""


@pytest.mark.parametrize("at", [load(10), load(1, oldest_s=5.0)])
def test_deliberation_is_shed_first_by_number_or_by_age_and_never_of_a_critical_event(at: Load) -> None:
    overload = Overload(SETTINGS)
    assert overload.objection(event(), at) == ""
    assert overload.sheds(event(), at).startswith(SHED)
    assert overload.sheds(event(CRITICAL), at) == ""


def test_then_coverage_is_given_up_of_what_is_not_critical_and_at_last_of_criticals() -> None:
    overload = Overload(SETTINGS)
    assert overload.objection(event(2), load(79)) == ""
    assert overload.objection(event(2), load(80)).startswith(REFUSED)
    assert overload.objection(event(CRITICAL), load(99, 99, 1e6, 10**6)) == ""
    assert overload.objection(event(CRITICAL), load(100)).startswith(REFUSED)


def test_one_source_cannot_take_the_room_of_the_others() -> None:
    overload = Overload(SETTINGS)
    assert "source noisy holds 40" in overload.objection(event(source="noisy"), load(45, of_source=40))
    assert overload.objection(event(source="quiet"), load(45, of_source=5)) == ""
    assert overload.objection(event(CRITICAL, source="noisy"), load(45, of_source=40)) == ""


def test_open_processes_have_a_bound_too() -> None:
    assert "1000 processes are open" in Overload(SETTINGS).objection(event(), load(open_=1000))


def test_without_limits_nothing_is_given_up() -> None:
    overload = Overload(UNLIMITED)
    at = load(10**6, 10**6, 1e6, 10**7)
    assert overload.objection(event(), at) == ""
    assert overload.sheds(event(), at) == ""


def test_a_reason_depends_on_the_settings_alone_so_that_refusals_are_counted_by_it() -> None:
    overload = Overload(SETTINGS)
    assert overload.objection(event(), load(80)) == overload.objection(event(), load(99))


def test_ten_times_the_sustained_rate_loses_nothing_treats_criticals_first_and_drains(tmp_path: Path) -> None:
    settings = OverloadSettings(shed_backlog=40, refuse_backlog=200)
    told = virtual(times=10.0, seconds=6.0, folder=tmp_path, overload=settings)
    assert told["audit"]
    assert told["offered"] == 1000
    assert told["lost"] == 0
    assert isinstance(told["refused"], dict)
    assert sum(told["refused"].values()) + int(str(told["admitted"])) == 1000
    assert all(reason.startswith(REFUSED) for reason in told["refused"])
    # Deliberation is shed before coverage: not one is refused before the room for the shed ones is full.
    assert int(str(told["shed"])) > 40
    assert int(str(told["most_backlog"])) <= 200
    assert told["critical_admitted"] == told["critical_deliberated"] == 50
    assert float(str(told["critical_first_max_s"])) < 0.5 < float(str(told["other_first_p50_s"]))
    assert 0.0 < float(str(told["drained_s"])) < 30.0


def test_the_same_overload_gives_the_same_journal(tmp_path: Path) -> None:
    settings = OverloadSettings(shed_backlog=10, refuse_backlog=40)
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    first, second = (virtual(times=10.0, seconds=1.0, folder=tmp_path / name, overload=settings) for name in ("a", "b"))
    first["memory_mb"] = second["memory_mb"] = 0.0
    assert first == second

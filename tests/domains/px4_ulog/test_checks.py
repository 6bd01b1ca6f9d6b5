"""A report of checks names all that fails now."""

from __future__ import annotations

from tests.domains.watching import Watch
from wakeful.domains.px4_ulog.checks import Checks
from wakeful.domains.px4_ulog.event_names import REPORT_BEGINS, REPORT_ENDS, event_number
from wakeful.facts.events import Phase

EVERY_MODE = [255, 255, 255, 255]


def _report(watch: Watch, at_s: float, *checks: tuple[str, int, list[int], int]) -> None:
    watch.see(at_s, "event", id=1 << 24 | event_number(REPORT_BEGINS), log_levels=0x88)
    for name, level, modes, component in checks:
        number = 1 << 24 | event_number(name)
        watch.see(at_s, "event", id=number, log_levels=level << 4 | level, arguments=[*modes, component, 0, 0])
    watch.see(at_s, "event", id=1 << 24 | event_number(REPORT_ENDS), log_levels=0x88)


def test_a_check_that_the_next_report_leaves_out_is_well_again() -> None:
    watch = Watch(Checks)
    watch.see(0.0, "vehicle_status", nav_state=4, arming_state=1)
    failing = ("check_estimator_gps_fix_too_low", 4, EVERY_MODE, 3)
    _report(watch, 1.0, failing)
    _report(watch, 5.0, failing)
    _report(watch, 9.0)
    assert watch.phases() == [Phase.RAISED, Phase.CLEARED]
    assert watch.found()[0].entity == "gps"
    assert watch.shown == [("recovered", "gps")]


def test_a_check_that_concerns_another_mode_or_only_informs_is_no_event() -> None:
    watch = Watch(Checks)
    watch.see(0.0, "vehicle_status", nav_state=4, arming_state=1)
    _report(watch, 1.0, ("check_modes_offboard_signal", 3, [0, 64, 0, 0], 20), ("check_rc_dl_no_dllink", 6, EVERY_MODE, 12))
    assert watch.seen == []


def test_half_a_report_clears_nothing() -> None:
    watch = Watch(Checks)
    watch.see(0.0, "vehicle_status", nav_state=4, arming_state=1)
    _report(watch, 1.0, ("check_mag_missing", 3, EVERY_MODE, 27))
    watch.see(2.0, "event", id=1 << 24 | event_number(REPORT_ENDS), log_levels=0x88)
    assert watch.phases() == [Phase.RAISED]

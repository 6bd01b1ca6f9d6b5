"""One event for each wording, evidence for what repeats it."""

from __future__ import annotations

from tests.domains.watching import Watch
from wakeful.domains.px4_ulog.event_names import event_number
from wakeful.domains.px4_ulog.messages import Messages
from wakeful.facts.events import Phase


def test_a_warning_said_a_hundred_times_is_one_event() -> None:
    watch = Watch(Messages)
    for second in range(100):
        watch.see(float(second), "log", level="warning", text=f"[commander] Preflight: bias is {second / 10}")
    assert len(watch.events) == 1
    assert watch.phases() == [Phase.RAISED, *[Phase.REPEATED] * 99]
    assert watch.found()[-1].references == watch.found()[0].references


def test_an_error_is_an_outcome_each_time_it_is_said() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "log", level="error", text="[sensors] no barometer found on /dev/baro0 (2)")
    watch.see(5.0, "log", level="error", text="[sensors] no barometer found on /dev/baro0 (2)")
    assert watch.shown == [("fault", "*")] * 2
    assert watch.events[0].entity == "module sensors"


def test_a_warning_that_returns_after_a_quiet_minute_is_a_change() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "log", level=4, text="low link")
    watch.see(2.0, "log", level=4, text="low link")
    watch.see(80.0, "log", level=52, text="low link")
    assert watch.phases() == [Phase.RAISED, Phase.REPEATED, Phase.CHANGED]


def test_an_event_and_its_message_twin_are_one() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "event", id=1, log_levels=0x44, text="Manual control lost")
    watch.see(1.0, "log", level="warning", text="[commander] Manual control lost\t")
    assert len(watch.found()) == 1


def test_an_event_that_comes_as_a_number_is_known_by_its_name() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "event", id=(1 << 24) | event_number("commander_gcs_lost"), log_levels=0x44)
    assert "commander gcs lost" in watch.events[0].says


def test_a_numbered_event_beside_its_own_message_is_not_said_twice() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "log", level="warning", text="[commander] Connection to ground station lost\t")
    watch.see(1.0, "event", id=(1 << 24) | event_number("commander_gcs_lost"), log_levels=0x44)
    assert len(watch.found()) == 1


def test_what_quiet_modules_inform_about_is_no_event_but_their_warnings_are() -> None:
    watch = Watch(Messages)
    spec = watch._spec.settings
    spec["quiet_modules"] = ["logger"]
    watch = Watch(Messages, **spec)  # type: ignore[arg-type]
    watch.see(1.0, "log", level="info", text="[logger] Start file log (type: full)")
    watch.see(2.0, "log", level="warning", text="[logger] storage full")
    assert [one.kind for one in watch.events] == ["warning_message"]


def test_debug_chatter_is_nothing() -> None:
    watch = Watch(Messages)
    watch.see(1.0, "log", level="debug", text="tick")
    assert watch.seen == []


def test_a_check_in_words_is_left_to_the_checks() -> None:
    watch = Watch(Messages)
    values = {"name": "check_modes_offboard_signal", "text": "No offboard signal", "group": "arming_check", "level": "error"}
    watch.see(1.0, "event", id=19865031, log_levels=0x33, **values)
    assert watch.seen == []

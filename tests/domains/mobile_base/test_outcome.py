"""A drive that ends in a stop, through the whole kernel: the stop is the outcome of what was registered before it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from wakeful.contracts.bridge import Item
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.events import Observation
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Admitted, Gained, Judged, Witnessed
from wakeful.facts.time import to_ns, to_s
from wakeful.journal import MemoryJournal

STARTS_S, STOPS_S, ENDS_S = 2.0, 8.0, 40.0


def drive() -> Iterator[Item]:
    """Odometry at 20 Hz as a bag holds it: at rest, 0.5 m/s, at rest again."""
    x = 0.0
    for tick in range(int(20 * ENDS_S)):
        at_s = tick / 20
        vx = 0.5 if STARTS_S <= at_s < STOPS_S else 0.0
        x += vx / 20
        values = {"vx": vx, "vy": 0.0, "wz": 0.0, "x": x, "y": 0.0, "yaw": 0.0, "child_frame": "base_link"}
        yield Observation(
            source="drive",
            position=tick,
            topic="/odom",
            at_ns=to_ns(at_s),
            values={"_type": "nav_msgs/msg/Odometry", **values},
        )


def after(position: int) -> Iterable[Item]:
    return (item for item in drive() if isinstance(item, Observation) and item.position > position)


def test_a_stop_within_the_window_of_an_earlier_event_is_its_matched_outcome() -> None:
    kernel, learner = assemble("mobile_base")
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(kernel.domain.spec), learner)
    for _ in driver.run("drive", "digest", after):
        pass
    driver.close()
    records = [line.record for line in journal.lines()]
    (start,) = (one.event for one in records if isinstance(one, Admitted) and one.event.kind == "start")
    (stop,) = (one.outcome for one in records if isinstance(one, Witnessed) and one.outcome.label == "stopped")
    assert STOPS_S < to_s(stop.at_ns) < STOPS_S + 1.0
    (judged,) = (one for one in records if isinstance(one, Judged) and one.event == start.id)
    assert (judged.label, judged.outcome) == ("stopped", stop.id)
    # the guidelines expect that it drives on
    assert (judged.predicted, judged.verdict) == ("none", Verdict.CONTRADICTED)
    (experience,) = (one.experience for one in records if isinstance(one, Gained) and one.experience.event == start.id)
    assert experience.outcome == "stopped"

"""What falls due, where a live driver lets only so many steps be done at a time: steps are put off, limits are not."""

from __future__ import annotations

import msgspec
import pytest

from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.treatment import Mind
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import Draft, Event
from wakeful.facts.inputs import Begin, Input
from wakeful.facts.lines import Answered
from wakeful.facts.results import Result
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import NS_PER_S
from wakeful.journal import MemoryJournal
from wakeful.journal.audit import audit
from wakeful.kernel import Kernel
from wakeful.treatments.decorator import treatment
from wakeful.treatments.registry import Registry

START_NS = 1_700_000_000 * NS_PER_S

#: Events that come at one instant, so that their limits pass at one instant too: a reasoner that never answers has a minute.
AT_ONCE = 6
LIMIT_S = 60.0


class Thought(Result, frozen=True, kw_only=True, tag="thought"):
    """What the treatment concludes."""


@treatment(name="ponder", says="Thinks in two steps, once the reasoner has answered or its time is over.")
async def ponder(event: Event, mind: Mind) -> Thought:
    await mind.work()
    await mind.work()
    return Thought(says=f"thought about {event.entity}", confidence=1.0)


class OneTreatment:
    """Anybody's events, pondered."""

    def __init__(self) -> None:
        rule = Guideline(treat="ponder", because="a test")
        self.spec: DomainSpec = msgspec.structs.replace(load("jsonl").spec, treatments=("ponder",), guideline=(rule,))

    def detectors(self) -> dict[str, DetectorFactory]:
        return {}

    def simulate(self, seed: int) -> None:
        return None


class Fed:
    """A kernel whose every feed is committed at once."""

    def __init__(self) -> None:
        settings = MindSettings(step_s=0.0, trains=False)
        self.kernel: Kernel = assemble(OneTreatment(), settings, registry=Registry(own=(ponder,), installed=()))[0]
        self.journal = MemoryJournal()

    def feed(self, inputs: list[Input], after_s: float, steps: int | None = None, hold: bool = False) -> None:
        at_ns = START_NS + round(after_s * NS_PER_S)
        requests = self.kernel.feed(inputs, at_ns, steps, hold=hold)
        self.journal.commit(requests.lines, self.kernel.changed(), requests.blobs)

    def expired_after_s(self) -> list[float]:
        """When each wait for the reasoner ran out."""
        expired = [line for line in self.journal.lines() if isinstance(line.record, Answered) and line.record.error == "expired"]
        return [(line.at_ns - START_NS) / NS_PER_S for line in expired]


def drafts() -> list[Input]:
    made = [Draft(kind="alarm", entity=f"pump {n}", source="made", position=n, at_ns=START_NS) for n in range(AT_ONCE)]
    return [Begin(source="made", digest="digest"), *made]


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_limits_that_pass_at_one_instant_all_pass_then_however_few_steps_a_feed_may_do(steps: int) -> None:
    fed = Fed()
    fed.feed(drafts(), 0.0)
    after_s = LIMIT_S - 1.0
    while fed.kernel.runnable or after_s < LIMIT_S + 2.0:
        fed.feed([], after_s, steps)
        after_s += 0.3
    assert fed.expired_after_s() == [LIMIT_S] * AT_ONCE
    assert audit(fed.journal).first_offender is None


def test_a_limit_passes_while_no_treatment_may_run() -> None:
    fed = Fed()
    fed.feed(drafts(), 0.0)
    later = Draft(kind="alarm", entity="pump 99", source="made", position=99, at_ns=START_NS + 61 * NS_PER_S)
    fed.feed([later], LIMIT_S + 1.0, hold=True)
    assert fed.expired_after_s() == [LIMIT_S] * AT_ONCE
    fed.feed([], LIMIT_S + 1.1)
    fed.feed([], 2 * LIMIT_S + 3.0)
    assert not fed.kernel.runnable
    assert audit(fed.journal).first_offender is None

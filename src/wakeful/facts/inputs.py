"""What the driver may feed the kernel, and what the kernel wants done in return."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

import msgspec

from wakeful.facts.asking import Question, Safety
from wakeful.facts.events import Draft, Observation, Undecodable
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.experience import ModelCard
from wakeful.facts.packs import Entry
from wakeful.facts.values import NOTHING, Fact, Raw


class Begin(Fact, frozen=True):
    """A source is about to be read. ``digest`` is of its content, or the incarnation of a live one.

    ``offset_ns`` takes its clock to kernel time. Given for a source that is being read, it says that the clock was set anew.
    """

    source: str
    digest: str
    offset_ns: int = 0


class End(Fact, frozen=True):
    """A source was read to its end. ``unbroken``: no gap up to its last observation."""

    source: str


class Answer(Fact, frozen=True):
    """The answer to one call: ``value`` as JSON, or ``error``."""

    process: int
    seq: int
    value: Raw = NOTHING
    error: str = ""
    cost_usd: float = 0.0
    calls: int = 0


class Trained(Fact, frozen=True):
    """A training's answer, to be fed at the instant that its TrainingAsked declared (live: when it is there)."""

    training: int
    card: ModelCard
    weights: bytes = b""


class Mark(Fact, frozen=True):
    """The source cursor: everything up to ``position`` has been fed. Committed together with what it led to."""

    source: str
    position: int


class Instant(msgspec.Struct, frozen=True, gc=False):
    """Kernel time goes on to ``at_ns``: what falls due by then is done first. So what came one by one is fed together."""

    at_ns: int


class Act(Fact, frozen=True):
    """An operator's act: ``hold``, ``release``, ``cancel``, ``reopen`` of a process, or ``rollback`` to a model version.

    ``id`` makes it idempotent: the same id fed twice acts once. An act without one is a new act each time.
    """

    who: str
    act: str
    process: int
    why: str
    id: str = ""
    event: str = ""
    """With ``reopen``: the event of the completed process."""
    version: int = 0
    """With ``rollback``: the model version to decide with from then on."""


Input: TypeAlias = Begin | End | Mark | Instant | Observation | Undecodable | Draft | Evidence | Outcome | Answer | Trained | Act

Outside: TypeAlias = Callable[[], "Awaitable[object] | object"]


class Call(msgspec.Struct, frozen=True, kw_only=True):
    """A call outside that the driver makes once the lines are durable: a reasoner, a person, or a user's function."""

    process: int
    seq: int
    asked_ns: int
    expires_ns: int
    question: Question | None = None
    role: str = ""
    function: Outside | None = None
    safety: Safety = "read"
    key: str = ""


class Training(msgspec.Struct, frozen=True, kw_only=True):
    """A training that the driver runs off the kernel's thread; ``job`` is what the learner takes."""

    training: int
    publish_ns: int
    job: TrainingJob


class TrainingJob(msgspec.Struct, frozen=True, kw_only=True):
    """All that a training needs, as numbers. Row i of each array is one experience.

    Shapes: features (n, d) float64; treatment (n,) int, -1 where the right treatment is not known; result (n,) int,
    -1 where undecided; refuted (n,) int, the index of a treatment known to be wrong or -1; weight (n,) float64.
    Rows stand in the order in which they were gained. ``held_back`` rows (by mask) are for champion/challenger and
    calibration only. ``right`` (n,) bool says whether what was concluded at the time came true, where that is known.
    ``advised`` (n,) int is the treatment that deliberation chose at the time, or -1 where nobody deliberated.
    """

    training: int
    base_version: int
    base_weights: bytes
    watermark: int
    seed: int
    epochs: int
    treatments: tuple[str, ...]
    labels: tuple[str, ...]
    features: object
    treatment: object
    result: object
    refuted: object
    weight: object
    held_back: object
    right: object = None
    advised: object = None


class Requests(msgspec.Struct, frozen=True, kw_only=True):
    """What the kernel wants done. The driver commits lines (packed or not) and blobs, with the kernel's ``changed()`` state, in
    one transaction before it acts on the rest."""

    lines: tuple[Entry, ...] = ()
    blobs: dict[str, bytes] = {}
    calls: tuple[Call, ...] = ()
    trainings: tuple[Training, ...] = ()
    wake_ns: int | None = None
    """When the kernel wants to be fed again, inputs or not; None: only when something comes."""
    left: int = 0
    """So many of the inputs were not taken: something outside is to be done first, at the instant that the kernel has come to."""

    def then(self, later: Requests) -> Requests:
        """These and the next feed's as one, to be committed together."""
        return Requests(
            lines=self.lines + later.lines,
            blobs={**self.blobs, **later.blobs},
            calls=self.calls + later.calls,
            trainings=self.trainings + later.trainings,
            wake_ns=later.wake_ns,
            left=later.left,
        )

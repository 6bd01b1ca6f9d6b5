"""What the journal records: one typed record per line, append-only. The kernel's state is the fold of these lines."""

from __future__ import annotations

import msgspec

from wakeful.facts.asking import Kind, Safety
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.processes import State, Trigger
from wakeful.facts.results import Forecast
from wakeful.facts.values import NOTHING, Raw


class Record(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, tag_field="is", tag=str.lower):
    """Base of every record. ``process`` and ``event`` are repeated in the line's own columns for look-up."""


class Opened(Record, frozen=True):
    """A source began (``resumed_at`` > 0: went on after that position). ``offset_ns`` maps its clock to kernel time."""

    source: str
    digest: str
    domain: str
    domain_version: int
    offset_ns: int
    seed: int
    resumed_at: int = 0
    software: str = ""


class Finished(Record, frozen=True):
    """A source was read to its end; its next reading starts with fresh registration state."""

    source: str
    observations: int


class Admitted(Record, frozen=True):
    """An event entered cognition and is owed coverage."""

    event: Event


class Duplicate(Record, frozen=True):
    """An event that was admitted before came again."""

    event: str
    source: str
    position: int


class Refused(Record, frozen=True):
    """An input that could not be admitted, and why. ``unread``: nobody knows what it was; it may have been an outcome."""

    source: str
    position: int
    reason: str
    unread: bool = False
    event: str = ""
    excerpt: str = ""


class Created(Record, frozen=True):
    """A process exists for the event from here on. Roots have no parent."""

    process: int
    event: str
    treatment: str
    criticality: int
    parent: int = 0
    reopens: int = 0
    deadline_ns: int | None = None


class Decided(Record, frozen=True):
    """What and how, for one process. A later one for the same process (deliberation answered, fallback) supersedes it."""

    process: int
    event: str
    decision: Decision


class Moved(Record, frozen=True):
    """One transition of the process table. ``steps`` is the process's total of completed steps so far.

    ``by`` names the process that preempted, the evidence that woke, or the operator.
    """

    process: int
    before: State
    trigger: Trigger
    after: State
    steps: int = 0
    by: str = ""


class Asked(Record, frozen=True):
    """A process asked for something; ``seq`` counts its requests from 1. Every wait has a limit: ``expires_ns``."""

    process: int
    seq: int
    kind: Kind
    key: str
    expires_ns: int | None
    safety: Safety = "read"
    count: int = 1
    args: str = ""
    """Digest of the arguments, by which an answer may be reused after the code has changed."""
    detail: Raw = NOTHING


class Answered(Record, frozen=True):
    """The answer to exactly that request. ``error`` instead of a value: refused, failed, or ``expired``."""

    process: int
    seq: int
    kind: Kind
    key: str
    value: Raw = NOTHING
    error: str = ""
    cost_usd: float = 0.0
    calls: int = 0


class Concluded(Record, frozen=True):
    """A process's result. ``result`` is the treatment's typed result as JSON, with its ``type``."""

    process: int
    event: str
    treatment: str
    mode: str
    result: Raw
    forecast: Forecast | None = None
    closes_ns: int | None = None
    """When the window closes in which the world may still show the forecast's outcome."""


class Witnessed(Record, frozen=True):
    """An outcome arrived from the world or a person."""

    outcome: Outcome


class Judged(Record, frozen=True):
    """A recorded result compared with an outcome: V(r, y). ``outcome`` empty: the window closed over ``none``."""

    process: int
    event: str
    predicted: str
    label: str
    verdict: Verdict
    outcome: str = ""
    why: str = ""
    lead_ns: int | None = None


class Gained(Record, frozen=True):
    """An experience was added to the learning material."""

    experience: Experience


class TrainingAsked(Record, frozen=True):
    """A training was requested: on which experiences, from which base, with which seed, and when it is published."""

    training: int
    base: int
    watermark: int
    seed: int
    epochs: int
    publish_ns: int


class Published(Record, frozen=True):
    """A training's answer: a new model version, accepted or not."""

    training: int
    card: ModelCard


class Trusted(Record, frozen=True):
    """Trust in a treatment changed."""

    treatment: str
    before: float
    after: float
    why: str
    experience: int = 0


class Certified(Record, frozen=True):
    """A treatment may be automatic for scores from ``level`` on, by one model version: its risk is held under ``alpha``.

    ``number`` counts the treatment's certificates; this one is wrong with probability at most ``delta``, which is its part of
    the user's, ``promised``. ``events`` is the evidence, ``drawn`` of it with a known outcome, ``errors`` wrong at that level.
    """

    treatment: str
    model: int
    number: int
    level: float
    alpha: float
    delta: float
    promised: float
    bound: float
    events: int
    drawn: int
    errors: int


class Revoked(Record, frozen=True):
    """A treatment's certificate ended: it is not automatic until it is certified again."""

    treatment: str
    model: int
    number: int
    why: str


class Drifted(Record, frozen=True):
    """A treatment errs more than it did: of its last ``of`` results ``wrong`` were contradicted, ``before`` is the share that was
    usual. ``changed``: one forecast fails consistently; else outcomes have become noisier."""

    treatment: str
    before: float
    wrong: int
    of: int
    changed: bool
    why: str


class Reopened(Record, frozen=True):
    """A completed process's event is thought about again, in a new process linked to the old."""

    process: int
    reopens: int
    event: str
    because: str


class Acted(Record, frozen=True):
    """An operator's act, with who and why. ``refused`` says why it changed nothing, where it did not."""

    who: str
    act: str
    process: int
    why: str
    id: str = ""
    refused: str = ""
    version: int = 0


class Imported(Record, frozen=True):
    """An experience that another robot made, with its event as it was there. ``experience.id`` is counted in this journal.

    ``origin`` and ``origin_id`` say whose it is: the journal that it was exported from, and its id there. It is learning
    material and can be remembered; it is no event of this journal, and no outcome of it counts for a guarantee here.
    """

    experience: Experience
    event: Event
    origin: str
    origin_id: int
    domain: str = ""


#: What a Noted says of a stretch, ending then, in which its source was not recording.
GAP = "recording gap"

#: What a Noted says of a journal whose last commits are gone, though they had been durable.
LOST_END = "the journal lost its end"

#: What a Noted says of a call that was under way when its mind ended, and is made again: it is charged again too.
RESUMPTION = "resumption"


class Noted(Record, frozen=True):
    """Something a person should know: a clock that ran back, a gap, code that no longer matches its record."""

    what: str
    detail: str
    source: str = ""
    process: int = 0
    event: str = ""


class Compacted(Record, frozen=True):
    """Stands for the lines from ``first`` up to its own position, which were too old to be kept: their counts.

    All they told of events that are closed and owed nothing is gone; ``admitted``, ``duplicate`` and ``refused`` are as many
    inputs as they were the fate of, ``gained`` as many experiences. ``process`` and ``experience`` are the highest ids in them.
    """

    first: int
    lines: int
    admitted: int = 0
    duplicate: int = 0
    refused: int = 0
    gained: int = 0
    process: int = 0
    experience: int = 0


AnyRecord = (
    Opened
    | Finished
    | Admitted
    | Duplicate
    | Refused
    | Created
    | Decided
    | Moved
    | Asked
    | Answered
    | Concluded
    | Witnessed
    | Judged
    | Gained
    | TrainingAsked
    | Published
    | Trusted
    | Certified
    | Revoked
    | Drifted
    | Reopened
    | Acted
    | Imported
    | Noted
    | Compacted
)


class Line(msgspec.Struct, frozen=True):
    """One line of the journal: its position (from 1), the kernel time, and the record."""

    position: int
    at_ns: int
    record: AnyRecord

"""One robot family's vocabulary, as data: what a domain's TOML file may say.

A domain is data first; code (detectors of its own, a simulator) only where it must be.
"""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.values import Fact, Field

Scalar = bool | int | float | str


class FieldSpec(Fact, frozen=True):
    """One field of the domain's events. ``values`` makes it categorical; ``low``/``high`` scale a number to [0, 1].

    ``size`` is the length of a numeric vector (a trace, a descriptor) whose every number is scaled so.
    ``channel`` names a channel whose last value stands in the context of every event under the field's name, ``since`` one
    whose seconds since its last change do; both may use ``{number}``, the number in the name of the event's entity.
    ``meaning`` says what the field stands for: it is a glossary for people, never a statement about an event. ``compared``:
    whether ``comparison`` and ``memory`` compare events by it; unless said, by all but what
    ``wakeful.contracts.detector.BOOKKEEPING`` names (how far out of its band a value is).
    """

    values: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 1.0
    size: int = 1
    meaning: str = ""
    compared: bool | None = None
    channel: str = ""
    since: str = ""


class DetectorSpec(Fact, frozen=True):
    """One detector: which observations it looks at and which events it registers.

    ``channels`` are ``topic/name`` patterns with ``*``; ``entity`` may use ``{channel}``, ``{topic}``, ``{name}``, ``{robot}``
    and ``{number}`` (the last number in the channel's name).
    """

    detector: str
    kind: str
    channels: tuple[str, ...] = ("*",)
    entity: str = "{channel}"
    criticality: int = 0
    deadline_s: float | None = None
    settings: dict[str, Scalar | list[Scalar]] = {}
    says: str = ""


class OutcomeSpec(Fact, frozen=True):
    """What the world may show later, and for how long a result waits for it.

    ``labels[0]`` is what an unbroken window without any outcome means (usually ``none``). ``gap_s``: a source that is not
    heard for longer was not recording then, and windows over such a stretch stay undecided; None for sources that speak
    only when something happens. ``scope``: ``entity`` matches outcomes of the event's own entity (and of ``*``), ``robot``
    any outcome of the robot. ``incidents`` are the labels that are bad ends, by which is told how well registration hears;
    none named: all but the first.
    """

    topic: str = "outcome"
    labels: tuple[str, ...] = ("none", "intervention")
    within_s: float = 60.0
    scope: str = "entity"
    gap_s: float | None = None
    incidents: tuple[str, ...] = ()


class OutcomeSource(Fact, frozen=True):
    """A channel whose rising edge, or change, is an outcome."""

    channel: str
    label: str
    entity: str = "*"


class EvidenceSource(Fact, frozen=True):
    """A channel offered as evidence: a mean over ``every_s``, kept for ``keep_s`` for who asks later.

    Without ``channels`` it is declared only: a detector of the domain's own offers it, keyed by the entity, about every
    ``every_s``. ``fields`` names what the value tells of (members where it is an object), if that is not the channel's name.
    """

    topic: str
    channels: tuple[str, ...]
    key: str = "{channel}"
    every_s: float = 1.0
    keep_s: float = 30.0
    fields: tuple[str, ...] = ()


class Guideline(Fact, frozen=True):
    """One written guideline: when these fields hold, treat so, because. First by ``weight``, then by order.

    ``when`` maps a field (or ``kind``, ``relation``, ``entity``, ``task``, ``zone``, ``safety``) to a value, a list of values,
    or a comparison such as ``">0.6"``.
    """

    treat: str
    because: str
    when: dict[str, Scalar | list[Scalar]] = {}
    expect: str = ""
    probability: float = 0.5
    weight: float = 1.0


class Hazard(Fact, frozen=True):
    """A row of the hazard table: severity class 1 (slight) to 4 (fatal), exposure and prior likelihood in [0, 1].

    ``outcomes`` are the outcome labels that show it come true, from which its likelihood is learned. Where none is named it is
    the hazard's own name if that is a label, else the only label beside the first; with more labels nothing is learned.
    """

    name: str
    severity: int
    exposure: float
    likelihood: float
    when: dict[str, Scalar | list[Scalar]] = {}
    control: str = ""
    outcomes: tuple[str, ...] = ()
    rule: str = ""
    """A formula of signal temporal logic over vector fields of the event: where they keep it, the hazard is not open."""


class Fault(Fact, frozen=True):
    """A device fault for noisy-OR diagnosis: its prior, and the probability that it causes each symptom.

    A symptom is an event kind or ``field=value``.
    """

    name: str
    prior: float
    causes: dict[str, float]
    check: str = ""
    remedy: str = ""


class Route(Fact, frozen=True):
    """An edge of the route graph."""

    start: str
    end: str
    cost: float = 1.0
    two_way: bool = True


class Errand(Fact, frozen=True):
    """One thing to do at a place, after others of the same task."""

    does: str
    at: str
    after: tuple[str, ...] = ()


class Task(Fact, frozen=True):
    """A task by its name, as an event's context names it: errands with their order, and where the robot ends."""

    name: str
    errands: tuple[Errand, ...]
    end: str = ""


class Cause(Fact, frozen=True):
    """An arrow of the causal graph between event kinds (or outcome labels), with its usual delay."""

    cause: str
    effect: str
    within_s: float
    strength: float = 0.5
    because: str = ""


class Recognise(Fact, frozen=True):
    """How a source of this domain is recognised: by bridge, by suffix, and by channels that must be there (patterns)."""

    bridges: tuple[str, ...] = ()
    suffixes: tuple[str, ...] = ()
    channels: tuple[str, ...] = ()


class DomainSpec(Fact, frozen=True):
    """A whole domain, as its TOML file declares it."""

    name: str
    version: int
    says: str
    robot: str = "robot"
    recognise: Recognise = Recognise()
    fields: dict[str, FieldSpec] = {}
    detect: tuple[DetectorSpec, ...] = ()
    outcome: OutcomeSpec = OutcomeSpec()
    outcomes: tuple[OutcomeSource, ...] = ()
    evidence: tuple[EvidenceSource, ...] = ()
    guideline: tuple[Guideline, ...] = ()
    hazard: tuple[Hazard, ...] = ()
    fault: tuple[Fault, ...] = ()
    one_fault: bool = False
    """Exactly one of the faults is there at a time, or none; else they come independently of one another."""
    route: tuple[Route, ...] = ()
    task: tuple[Task, ...] = ()
    cause: tuple[Cause, ...] = ()
    treatments: tuple[str, ...] = ()
    """Treatments that may be chosen here; empty: all that are registered."""


def matches(when: Mapping[str, Scalar | list[Scalar]], has: Mapping[str, Field]) -> bool:
    """Whether every condition of ``when`` holds in ``has`` (a field that is absent never holds).

    >>> matches({"state": "unstable", "load": ">0.6"}, {"state": "unstable", "load": 0.7})
    True
    >>> matches({"location": ["edge", "route"]}, {"location": "center"})
    False
    """
    return all(name in has and _holds(wanted, has[name]) for name, wanted in when.items())


def _holds(wanted: Scalar | list[Scalar], value: Field) -> bool:
    if isinstance(wanted, list):
        return value in wanted
    if isinstance(wanted, str) and wanted[:1] in "<>" and wanted[:1]:
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        sign = wanted[:2] if wanted[1:2] == "=" else wanted[:1]
        limit = float(wanted[len(sign) :])
        return {"<": value < limit, "<=": value <= limit, ">": value > limit, ">=": value >= limit}[sign]
    return value == wanted

"""A domain's TOML file, read and checked: one clear error names the file, the place in it, and what to do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TypeVar

import msgspec

from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import (
    Cause,
    DetectorSpec,
    DomainSpec,
    Fault,
    FieldSpec,
    Guideline,
    Hazard,
    OutcomeSpec,
    Route,
    Scalar,
)
from wakeful.facts.values import Fact

Declared = TypeVar("Declared", "DomainSpec", "Knowledge")

EVENT_WORDS = ("kind", "relation", "entity", "task", "zone", "safety", "criticality", "condition")
"""What a ``when`` may name beside the domain's own fields."""


KNOWLEDGE = "knowledge.toml"
"""The file beside a folder's ``domain.toml`` that may hold the tables of what is known, apart from what can be seen."""


class Knowledge(Fact, frozen=True):
    """What ``knowledge.toml`` may say: the tables of a DomainSpec that a person who knows the robots writes down."""

    guideline: tuple[Guideline, ...] = ()
    hazard: tuple[Hazard, ...] = ()
    fault: tuple[Fault, ...] = ()
    cause: tuple[Cause, ...] = ()
    route: tuple[Route, ...] = ()


def read_spec(path: Path) -> DomainSpec:
    """The domain that a TOML file declares, with the tables of ``knowledge.toml`` where the file is a folder's ``domain.toml``.

    Returns:
        The checked data: every label, field and probability that one table names in another is there and in range.

    Raises:
        DomainError: a file is absent, is not TOML, has an unknown or missing field, or contradicts itself or the other.
    """
    spec = _decoded(_text(path), str(path), DomainSpec)
    beside = path.with_name(KNOWLEDGE)
    if path.name != "domain.toml" or not beside.is_file():
        return _checked(spec, str(path))
    known = msgspec.structs.asdict(_decoded(_text(beside), str(beside), Knowledge))
    tables = {name: rows for name, rows in known.items() if rows}
    for name in tables:
        if getattr(spec, name):
            raise DomainError(f"{beside}: {name}: {path.name} has this table too; keep it in one of the two")
    return _checked(msgspec.structs.replace(spec, **tables), str(path), dict.fromkeys(tables, str(beside)))


def parse_spec(text: bytes | str, where: str) -> DomainSpec:
    """The domain that TOML text declares; ``where`` names it in errors. Raises DomainError as `read_spec` does."""
    return _checked(_decoded(text, where, DomainSpec), where)


def _text(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise DomainError(f"{path}: cannot be read ({error.strerror or error}); give the path of a domain's TOML file") from error


def _decoded(text: bytes | str, where: str, kind: type[Declared]) -> Declared:
    try:
        return msgspec.toml.decode(text, type=kind)
    except msgspec.ValidationError as error:
        raise DomainError(f"{where}: {error}; see the fields of DomainSpec in wakeful.facts.domain") from error
    except (msgspec.DecodeError, UnicodeDecodeError, ValueError) as error:
        raise DomainError(f"{where}: not TOML ({error}); correct that line") from error


def _checked(spec: DomainSpec, where: str, elsewhere: Mapping[str, str] = MappingProxyType({})) -> DomainSpec:
    """``spec``, or an error that names the file of the mistake: ``elsewhere`` gives the tables that another file declares."""
    for place, wrong, remedy in _mistakes(spec):
        raise DomainError(f"{elsewhere.get(place.split()[0], where)}: {place}: {wrong}; {remedy}")
    return spec


Mistake = tuple[str, str, str]


def _mistakes(spec: DomainSpec) -> Iterator[Mistake]:
    if not spec.name or "/" in spec.name:
        yield "name", f"{spec.name!r} is not a name", "use a short word such as `my_robot`"
    if spec.version < 1:
        yield "version", f"{spec.version} is not a version", "count from 1"
    for name, field in spec.fields.items():
        yield from _field_mistakes(f"fields.{name}", field)
    for number, detector in enumerate(spec.detect, 1):
        yield from _detector_mistakes(f"detect {number} ({detector.kind})", detector)
    yield from _outcome_mistakes(spec.outcome)
    labels = spec.outcome.labels
    for number, source in enumerate(spec.outcomes, 1):
        if source.label not in labels:
            yield f"outcomes {number}", f"label {source.label!r} is not in outcome.labels", f"use one of {', '.join(labels)}"
    for number, evidence in enumerate(spec.evidence, 1):
        if not (evidence.every_s > 0 and evidence.keep_s > 0):
            yield f"evidence {number} ({evidence.topic})", "every_s and keep_s must be above 0", "give seconds"
    for number, guideline in enumerate(spec.guideline, 1):
        yield from _guideline_mistakes(f"guideline {number} ({guideline.treat})", guideline, spec)
    for hazard in spec.hazard:
        yield from _hazard_mistakes(f"hazard {hazard.name}", hazard)
        yield from _when_mistakes(f"hazard {hazard.name}", hazard.when, spec)
        for label in hazard.outcomes:
            if label not in labels:
                yield f"hazard {hazard.name}", f"outcome {label!r} is not in outcome.labels", f"use one of {', '.join(labels)}"
    for fault in spec.fault:
        for what, probability in (("prior", fault.prior), *fault.causes.items()):
            yield from _probability(f"fault {fault.name}", what, probability)
    for cause in spec.cause:
        yield from _probability(f"cause {cause.cause} -> {cause.effect}", "strength", cause.strength)
        if not cause.within_s > 0:
            yield f"cause {cause.cause} -> {cause.effect}", "within_s must be above 0", "give the usual delay in seconds"


def _field_mistakes(place: str, field: FieldSpec) -> Iterator[Mistake]:
    if not field.values and not field.low < field.high:
        yield place, f"low {field.low} is not below high {field.high}", "give the range of its usual values"
    if len(set(field.values)) != len(field.values):
        yield place, "a value stands twice", "name each value once"


def _detector_mistakes(place: str, detector: DetectorSpec) -> Iterator[Mistake]:
    if not detector.kind:
        yield place, "kind is empty", "name the kind of event that it registers"
    if not detector.channels:
        yield place, "no channels", "give `topic/name` patterns, or leave the line out for all"
    if detector.criticality not in (0, 1, 2, 3):
        yield place, f"criticality {detector.criticality}", "use 0 routine, 1 notable, 2 urgent or 3 critical"
    if detector.deadline_s is not None and not detector.deadline_s > 0:
        yield place, f"deadline_s {detector.deadline_s} must be above 0", "give seconds or leave it out"


def _outcome_mistakes(outcome: OutcomeSpec) -> Iterator[Mistake]:
    if not outcome.labels or len(set(outcome.labels)) != len(outcome.labels):
        yield "outcome.labels", "needs at least one label, each once", 'for instance ["none", "intervention"]'
    for label in outcome.incidents:
        if label not in outcome.labels:
            yield "outcome.incidents", f"{label!r} is not in outcome.labels", f"use some of {', '.join(outcome.labels)}"
    if not outcome.within_s > 0:
        yield "outcome.within_s", f"{outcome.within_s} must be above 0", "give seconds"
    if outcome.scope not in ("entity", "robot"):
        yield "outcome.scope", f"{outcome.scope!r}", "use `entity` or `robot`"


def _guideline_mistakes(place: str, guideline: Guideline, spec: DomainSpec) -> Iterator[Mistake]:
    if guideline.expect and guideline.expect not in spec.outcome.labels:
        yield place, f"expect {guideline.expect!r} is not in outcome.labels", f"use one of {', '.join(spec.outcome.labels)}"
    if spec.treatments and guideline.treat not in spec.treatments:
        yield place, f"{guideline.treat!r} is not in treatments", f"use one of {', '.join(spec.treatments)}"
    yield from _probability(place, "probability", guideline.probability)
    yield from _when_mistakes(place, guideline.when, spec)


def _hazard_mistakes(place: str, hazard: Hazard) -> Iterator[Mistake]:
    if hazard.severity not in (1, 2, 3, 4):
        yield place, f"severity {hazard.severity}", "use 1 (slight) to 4 (fatal)"
    yield from _probability(place, "exposure", hazard.exposure)
    yield from _probability(place, "likelihood", hazard.likelihood)


def _when_mistakes(place: str, when: Mapping[str, Scalar | list[Scalar]], spec: DomainSpec) -> Iterator[Mistake]:
    for name, wanted in when.items():
        if name not in spec.fields and name not in EVENT_WORDS and name not in _history(spec):
            yield f"{place}: when.{name}", "no such field", f"declare [fields.{name}], or use one of {', '.join(EVENT_WORDS)}"
        if isinstance(wanted, str) and wanted[:1] in ("<", ">"):
            try:
                float(wanted.lstrip("<>").removeprefix("="))
            except ValueError:
                yield f"{place}: when.{name}", f"{wanted!r} compares with no number", 'write for instance ">0.6"'


def _history(spec: DomainSpec) -> set[str]:
    """The fields of recent history that registration puts into every event's context (wakeful.registration.history)."""
    labels = {name for label in spec.outcome.labels for name in (f"since_{label}_s", f"recent_{label}")}
    return {"since_event_s", "recent_events", "since_entity_s", "recent_entity", "since_same_s", *labels}


def _probability(place: str, what: str, value: float) -> Iterator[Mistake]:
    if not 0.0 <= value <= 1.0:
        yield place, f"{what} {value} is not a probability", "use 0 to 1"

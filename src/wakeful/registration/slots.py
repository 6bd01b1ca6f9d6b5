"""The detectors of a domain in their places: made by name, each with the channels that it looks at."""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.contracts.detector import Detector, DetectorFactory
from wakeful.contracts.domain import DomainError
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.registration.channels import Channels
from wakeful.registration.sources import EvidenceDetector, OutcomeDetector

_SOURCE = DetectorSpec(detector="source", kind="source")


class Slot:
    """One detector in its place. ``key`` names its part of the state; ``dirty`` says that it may have changed."""

    __slots__ = ("channels", "detector", "dirty", "hears_all", "key", "spec")

    def __init__(self, key: str, detector: Detector, spec: DetectorSpec) -> None:
        self.key = key
        self.detector = detector
        self.spec = spec
        own = getattr(detector, "channels", None)
        self.channels = own if isinstance(own, Channels) else Channels(spec.channels)
        self.hears_all = bool(getattr(detector, "hears_all", False))
        self.dirty = False


def slots_of(spec: DomainSpec, factories: Mapping[str, DetectorFactory]) -> tuple[Slot, ...]:
    """The slots of a domain: outcome sources, evidence sources, then the detectors in the order of its file.

    A detector may have ``channels`` (a `Channels`) where it looks at more than its spec's patterns, and ``hears_all = True``
    where every observation tells it the time.

    Raises:
        DomainError: a detector of no known name.
    """
    slots = [
        Slot(f"outcome/{number}/{source.label}", OutcomeDetector(source, spec.robot), _SOURCE)
        for number, source in enumerate(spec.outcomes)
    ]
    slots += [
        Slot(f"evidence/{number}/{source.topic}", EvidenceDetector(source, spec.robot), _SOURCE)
        for number, source in enumerate(spec.evidence)
    ]
    for number, detector in enumerate(spec.detect):
        factory = factories.get(detector.detector)
        if factory is None:
            known = ", ".join(sorted(factories))
            raise DomainError(f"domain {spec.name}: detect {number + 1} names detector {detector.detector!r}; use one of {known}")
        slots.append(Slot(f"detect/{number}/{detector.detector}/{detector.kind}", factory(detector, spec), detector))
    return tuple(slots)

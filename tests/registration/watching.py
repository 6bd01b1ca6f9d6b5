"""What the detectors' tests share: a detector by name, and a stream of one channel."""

from __future__ import annotations

from collections.abc import Iterable

from wakeful.contracts.detector import Detector, Found, Offered, Shown
from wakeful.facts.domain import DetectorSpec, DomainSpec, Scalar
from wakeful.facts.events import Observation
from wakeful.facts.values import Value
from wakeful.registration.detectors import BUILT_IN

DOMAIN = DomainSpec(name="test", version=1, says="", robot="r1")


def detector(
    name: str, channels: tuple[str, ...] = ("t/*",), entity: str = "{name}", **settings: Scalar | list[Scalar]
) -> Detector:
    """A detector of registration, made as a domain would."""
    spec = DetectorSpec(detector=name, kind="k", channels=channels, entity=entity, settings=dict(settings))
    return BUILT_IN[name](spec, DOMAIN)


def seen(position: int, at_s: float, topic: str = "t", **values: Value) -> Observation:
    """One observation."""
    return Observation(source="s", position=position, topic=topic, at_ns=round(at_s * 1e9), values=values)


def watch(
    watcher: Detector, values: Iterable[Value], step_s: float = 1.0, start: int = 0
) -> list[tuple[int, Found | Shown | Offered]]:
    """Feed channel ``t/x``, one value a step: (index, what was found)."""
    return [
        (index, item)
        for index, value in enumerate(values, start)
        for item in watcher.observe(seen(index, index * step_s, x=value))
    ]


def founds(watcher: Detector, values: Iterable[Value], step_s: float = 1.0, start: int = 0) -> list[tuple[int, Found]]:
    """The same, of a detector that only finds."""
    return [(index, item) for index, item in watch(watcher, values, step_s, start) if isinstance(item, Found)]

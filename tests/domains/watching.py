"""Drives detectors by hand: observations by topic and seconds, what was found by kind."""

from __future__ import annotations

from collections.abc import Iterable

from hypothesis import strategies as st

from wakeful.contracts.detector import Detector, DetectorFactory, Found, Offered, Shown
from wakeful.facts.domain import DetectorSpec, DomainSpec
from wakeful.facts.events import Observation, Phase
from wakeful.facts.time import to_ns
from wakeful.facts.values import Value

DOMAIN = DomainSpec(name="test", version=1, says="a domain for tests")


class Watch:
    """One detector and all that it has said so far. At each step its memory goes through bytes, as in a restart."""

    def __init__(self, factory: DetectorFactory, **settings: bool | int | float | str) -> None:
        self._factory = factory
        self._spec = DetectorSpec(detector="tested", kind="tested", settings=dict(settings))
        self.detector: Detector = factory(self._spec, DOMAIN)
        self.seen: list[Found | Shown | Offered] = []
        self._position = 0

    def see(self, at_s: float, topic: str, **values: Value) -> list[Found | Shown | Offered]:
        """Give the detector one observation; returns what it said of it."""
        return self.look(Observation(source="test", position=self._position, topic=topic, at_ns=to_ns(at_s), values=values))

    def look(self, observation: Observation) -> list[Found | Shown | Offered]:
        """The same with an observation of one's own."""
        self._position += 1
        said = list(self.detector.observe(observation))
        state = self.detector.state()
        self.detector = self._factory(self._spec, DOMAIN)
        self.detector.restore(state)
        assert self.detector.state() == state
        self.seen.extend(said)
        return said

    @property
    def events(self) -> list[Found]:
        """What would become events: all that is found but repeats and clearings."""
        return [one for one in self.found() if one.phase not in (Phase.REPEATED, Phase.CLEARED)]

    def found(self, kind: str = "") -> list[Found]:
        """All that was found, of one kind or of any."""
        return [one for one in self.seen if isinstance(one, Found) and kind in ("", one.kind)]

    def phases(self, kind: str = "") -> list[Phase | None]:
        """The phases of what was found, in order."""
        return [one.phase for one in self.found(kind)]

    @property
    def shown(self) -> list[tuple[str, str]]:
        """Outcomes as (label, entity)."""
        return [(one.label, one.entity) for one in self.seen if isinstance(one, Shown)]


def anything() -> st.SearchStrategy[object]:
    """Values that no message should hold, and some that it should: of every type, of any size."""
    leaves = st.one_of(
        st.none(),
        st.booleans(),
        st.integers(min_value=-(10**25), max_value=10**25),
        st.integers(min_value=-3, max_value=300),
        st.floats(),
        st.sampled_from(["", "error", "warning", "no", "x" * 5000, "\ud800", "[", "[a] b\t"]),
        st.text(max_size=8),
    )
    return st.recursive(
        leaves,
        lambda inner: st.one_of(
            st.lists(inner, max_size=6), st.dictionaries(st.sampled_from(["name", "level", "child", "x"]), inner, max_size=4)
        ),
        max_leaves=8,
    )


def observations(topics: Iterable[str], names: Iterable[str], types: Iterable[str] = ()) -> st.SearchStrategy[list[Observation]]:
    """Streams over these topics and value names, with content of any kind and a clock that may run back."""
    values = st.dictionaries(st.sampled_from(sorted(names)), anything(), max_size=12)
    if types:
        values = st.builds(lambda content, kind: {**content, "_type": kind}, values, st.sampled_from([*sorted(types), 7, None]))
    one = st.builds(
        lambda topic, at_ns, content: Observation(source="t", position=0, topic=topic, at_ns=at_ns, values=content),
        st.sampled_from(sorted(topics)),
        st.one_of(st.integers(0, 10**11), st.integers(-(2**62), 2**62)),
        values,
    )
    return st.lists(one, max_size=12)

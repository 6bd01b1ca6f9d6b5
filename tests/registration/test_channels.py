"""Patterns that choose among channels."""

from __future__ import annotations

from fnmatch import fnmatchcase

from hypothesis import given
from hypothesis import strategies as st

from wakeful.facts.events import Observation
from wakeful.facts.values import Value
from wakeful.registration.channels import Channels, reaches

anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=4),
    max_leaves=8,
)


letters = st.text(alphabet="ab/", max_size=5)
patterns = st.text(alphabet="ab/*?", max_size=6)


@given(patterns, letters, letters)
def test_a_pattern_that_matches_a_channel_reaches_every_beginning_of_it(pattern: str, start: str, rest: str) -> None:
    if fnmatchcase(start + rest, pattern):
        assert reaches(pattern, start)


names = st.sampled_from(["J0", "J1", "x", "pose"])
shapes = st.dictionaries(names, st.sampled_from([1, {"x": 1, "y": {"z": 2}}]), max_size=4)


@given(st.lists(shapes, min_size=1, max_size=8), patterns)
def test_what_was_seen_before_never_changes_what_is_chosen(seen: list[dict[str, Value]], pattern: str) -> None:
    wanted = ("t/J*", "t/pose.*", f"t/{pattern}")
    used = Channels(wanted)
    for values in seen:
        observation = Observation(source="s", position=0, topic="t", at_ns=0, values=values)
        assert used.of(observation) == Channels(wanted).of(observation)

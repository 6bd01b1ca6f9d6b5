"""Whatever the bytes: one SourceError, or items with positions without gaps; never anything else, and no NaN."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TypeVar

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from wakeful.bridges import bridge_for
from wakeful.contracts.bridge import Item, SourceError
from wakeful.facts.events import Draft, Observation, Undecodable
from wakeful.facts.values import Value

T = TypeVar("T")

SUFFIXES = (".csv", ".xlsx", ".ulg", ".bag", ".db3", ".mcap", ".jsonl")
FUZZED = settings(max_examples=60, deadline=None, suppress_health_check=list(HealthCheck))

MUTATIONS = st.lists(
    st.tuples(st.sampled_from(("flip", "cut", "drop", "double", "zero")), st.integers(0, 2**20), st.integers(1, 255)),
    min_size=1,
    max_size=4,
)


def mutated(content: bytes, mutations: list[tuple[str, int, int]]) -> bytes:
    """The content with some bytes changed, left out, doubled, or its end cut off."""
    damaged = bytearray(content)
    for how, where, amount in mutations:
        at = where % max(1, len(damaged))
        if how == "flip" and damaged:
            damaged[at] ^= amount
        elif how == "cut":
            del damaged[at:]
        elif how == "drop":
            del damaged[at : at + amount]
        elif how == "double":
            damaged[at:at] = damaged[at : at + amount]
        else:
            damaged[at : at + amount] = bytes(len(damaged[at : at + amount]))
    return bytes(damaged)


def numbers(value: Value) -> Iterator[float]:
    if isinstance(value, float):
        yield value
    elif isinstance(value, Mapping):
        for inner in value.values():
            yield from numbers(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from numbers(inner)


def attempt(do: Callable[[], T]) -> tuple[T | None, str | None]:
    """What it gave, or what the one allowed error said."""
    try:
        return do(), None
    except SourceError as error:
        return None, str(error)


def check(path: Path) -> list[Item]:
    """What reading gives, checked; nothing where there is one SourceError."""
    bridge = bridge_for(path)
    _, refusal = attempt(lambda: bridge.peek(path))
    assert refusal is None or path.name in refusal
    items, refusal = attempt(lambda: list(bridge.read(path)))
    if items is None:
        assert refusal is not None
        assert path.name in refusal
        return []
    placed = [item.position for item in items if isinstance(item, Observation | Undecodable | Draft)]
    assert len(items) == len(placed) or path.suffix == ".jsonl"
    assert placed == sorted(set(placed))
    if len(items) == len(placed):
        assert placed == list(range(len(placed)))
    for item in items:
        if isinstance(item, Observation):
            assert all(map(math.isfinite, numbers(item.values)))
            assert abs(item.at_ns) < 2**63
            msgspec.json.encode(item)
        elif isinstance(item, Undecodable):
            assert item.reason
            msgspec.json.encode(item)
    middle = len(items) // 2
    if items and len(items) == len(placed):
        assert list(bridge.read(path, middle)) == items[middle + 1 :]
    return items


@pytest.mark.parametrize("suffix", SUFFIXES)
@FUZZED
@given(content=st.binary(max_size=400))
def test_random_bytes_are_one_error_or_refusals(suffix: str, content: bytes, tmp_path: Path) -> None:
    path = tmp_path / f"random{suffix}"
    path.write_bytes(content)
    check(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@FUZZED
@given(content=st.binary(max_size=400))
def test_random_bytes_after_a_true_beginning_are_one_error_or_refusals(
    suffix: str, content: bytes, recordings: dict[str, Path], tmp_path: Path
) -> None:
    path = tmp_path / f"begun{suffix}"
    path.write_bytes(recordings[suffix].read_bytes()[:64] + content)
    check(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@FUZZED
@given(mutations=MUTATIONS)
def test_a_damaged_recording_is_one_error_or_gives_what_is_left(
    suffix: str, mutations: list[tuple[str, int, int]], recordings: dict[str, Path], tmp_path: Path
) -> None:
    path = tmp_path / f"damaged{suffix}"
    path.write_bytes(mutated(recordings[suffix].read_bytes(), mutations))
    check(path)


@FUZZED
@given(text=st.text(max_size=200))
def test_any_text_as_lines_is_refused_line_by_line(text: str, tmp_path: Path) -> None:
    path = tmp_path / "text.jsonl"
    good = '{"topic": "pump", "pressure": 1}\n'
    path.write_text(f"{good}{text}\n{good}", encoding="utf-8", errors="replace", newline="")
    if "\0" not in text:
        items = check(path)
        assert [item.topic for item in (items[0], items[-1]) if isinstance(item, Observation)] == ["pump", "pump"]


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=10), inner, max_size=4),
    max_leaves=20,
)


@FUZZED
@given(word=st.sampled_from(("observation", "event", "evidence", "outcome", "message")), said=JSON)
def test_any_json_under_any_key_is_an_item_or_a_refusal(word: str, said: object, tmp_path: Path) -> None:
    path = tmp_path / "any.jsonl"
    path.write_text(json.dumps({word: said}) + "\n")
    assert len(check(path)) == 1

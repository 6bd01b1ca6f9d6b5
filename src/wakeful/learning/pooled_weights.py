"""A pooled model version as bytes: MessagePack of plain numbers and names, the network's own bytes among them."""

from __future__ import annotations

import msgspec
import numpy as np

from wakeful.learning.clauses import Clause
from wakeful.learning.forest import Forest
from wakeful.learning.material import Floats
from wakeful.learning.model import Model
from wakeful.learning.panel import Input, Panel
from wakeful.learning.rule_lists import RuleLists
from wakeful.learning.weights import from_bytes, to_bytes

FORMAT = 1
_MARK = b"wakeful pooled\n"
_DEEPEST = 12


class PooledModel(msgspec.Struct, frozen=True, kw_only=True):
    """A model version in memory. ``tested`` has not seen the rows held back from ``whole``; ``weights`` are of
    ``wakeful.learning.panel.EXPERTS``."""

    network: Model
    tested: Panel
    whole: Panel
    weights: tuple[float, ...]


class _StoredPanel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A panel; arrays little-endian float64, columns int32, row by row."""

    clauses: tuple[Clause, ...]
    lists: tuple[tuple[tuple[int, ...], ...], ...]
    spoken: bytes
    support: tuple[int, ...]
    say: tuple[float, ...]
    depth: int
    column: bytes
    cut: bytes
    leaf: bytes
    base: tuple[float, ...]
    inputs: tuple[Input, ...]


class _Stored(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    format: int
    network: bytes
    tested: _StoredPanel
    whole: _StoredPanel
    weights: tuple[float, ...]


def is_pooled(weights: bytes) -> bool:
    """Whether these are a pooled model's bytes (rather than a network's)."""
    return weights.startswith(_MARK)


def pooled_to_bytes(model: PooledModel) -> bytes:
    """The model as bytes: equal models, equal bytes."""
    stored = _Stored(
        format=FORMAT,
        network=to_bytes(model.network),
        tested=_stored(model.tested),
        whole=_stored(model.whole),
        weights=model.weights,
    )
    return _MARK + msgspec.msgpack.encode(stored)


def pooled_from_bytes(weights: bytes) -> PooledModel:
    """The model that ``pooled_to_bytes`` gave out.

    Raises:
        ValueError: the bytes are not a pooled model, are of another format, or their parts don't fit together.
    """
    try:
        stored = msgspec.msgpack.decode(weights.removeprefix(_MARK), type=_Stored)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"these {len(weights)} bytes are not the weights of a pooled model: {error}") from error
    if stored.format != FORMAT:
        raise ValueError(f"pooled weights of format {stored.format}; this version of wakeful reads format {FORMAT}")
    network = from_bytes(stored.network)
    if len(stored.weights) != 3 or not all(0.0 <= each < 1e6 for each in stored.weights):
        raise ValueError("the experts' weights are none that a training gives: the bytes are damaged")
    d, k = network.shape.inputs, network.shape.treatments
    return PooledModel(
        network=network, tested=_panel(stored.tested, d, k), whole=_panel(stored.whole, d, k), weights=stored.weights
    )


def _stored(panel: Panel) -> _StoredPanel:
    rules, forest = panel.rules, panel.forest
    return _StoredPanel(
        clauses=rules.clauses,
        lists=rules.lists,
        spoken=_bytes(rules.spoken),
        support=rules.support,
        say=rules.say,
        depth=(forest.column.shape[1] + 1).bit_length() - 1,
        column=forest.column.astype("<i4").tobytes(),
        cut=_bytes(forest.cut),
        leaf=_bytes(forest.leaf),
        base=tuple(forest.base.tolist()),
        inputs=panel.inputs,
    )


def _panel(stored: _StoredPanel, d: int, k: int) -> Panel:
    """The panel of a model of d features and k treatments. Raises ValueError where anything in it points outside."""
    inner = 2 ** min(max(0, stored.depth), _DEEPEST) - 1
    said = sum(len(rules) + 1 for rules in stored.lists)
    numbers = [stored.spoken, stored.cut, stored.leaf]
    whole = (
        1 <= stored.depth <= _DEEPEST
        and all(len(part) % 8 == 0 for part in numbers)
        and len(stored.spoken) == 8 * said * k
        and len(stored.support) == said
        and len(stored.say) == len(stored.lists)
        and len(stored.cut) == 2 * len(stored.column)
        and len(stored.column) % (4 * inner * k) == 0
        and len(stored.leaf) * inner == len(stored.cut) * (inner + 1)
        and len(stored.base) == k
        and all(0 <= each.column < d and each.other < d for each in stored.clauses)
        and all(0 <= column < d and other < d for column, other, _ in stored.inputs)
        and all(0 <= clause < len(stored.clauses) for rules in stored.lists for rule in rules for clause in rule)
    )
    column = np.frombuffer(stored.column, "<i4").astype(np.int64) if whole else np.zeros(0, np.int64)
    if not whole or (column.size and not 0 <= int(column.min()) <= int(column.max()) < len(stored.inputs)):
        raise ValueError("the parts of the pooled weights don't fit together: the bytes are damaged")
    spoken, leaf = _floats(stored.spoken).reshape(-1, k), _floats(stored.leaf).reshape(-1, inner + 1)
    if not (np.isfinite(spoken).all() and np.isfinite(leaf).all() and all(np.isfinite(stored.base))):
        raise ValueError("the pooled weights hold numbers that no training gives: the bytes are damaged")
    return Panel(
        rules=RuleLists(clauses=stored.clauses, lists=stored.lists, spoken=spoken, support=stored.support, say=stored.say),
        forest=Forest(
            column=column.reshape(-1, inner), cut=_floats(stored.cut).reshape(-1, inner), leaf=leaf, base=np.array(stored.base)
        ),
        inputs=stored.inputs,
    )


def _bytes(numbers: Floats) -> bytes:
    return numbers.astype("<f8").tobytes()


def _floats(data: bytes) -> Floats:
    return np.frombuffer(data, "<f8").astype(np.float64)

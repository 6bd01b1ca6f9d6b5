"""Any fact, by its type alone: hypothesis strategies for every struct that an entry may hold."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st
from msgspec import inspect

from wakeful.facts.values import NOTHING, Raw

_HEX = st.text("0123456789abcdef", min_size=20, max_size=20)
_TEXT = st.sampled_from(["", "a", "object", "é\x1f", "none"]) | st.text(max_size=9) | _HEX
_INT = st.integers(-(2**63), 2**64 - 1)
_FLOAT = st.floats(allow_nan=False, allow_infinity=False)
_FIELD = st.none() | st.booleans() | _INT | _FLOAT | _TEXT | st.lists(_FLOAT, max_size=3).map(tuple)
_RAW = st.sampled_from([NOTHING, Raw(b'{"type":"memory","says":"x"}'), Raw(b"[1,2.5]")])


def any_of(cls: type) -> st.SearchStrategy[Any]:
    """Any instance of a struct."""
    return _of(inspect.type_info(cls))


def _of(kind: inspect.Type) -> st.SearchStrategy[Any]:
    match kind:
        case inspect.StructType(cls=cls, fields=fields):
            return st.builds(cls, **{field.name: _of(field.type) for field in fields})
        case inspect.UnionType(types=types):
            others = [each for each in types if not isinstance(each, inspect.NoneType)]
            return _FIELD if len(others) > 1 else st.none() | _of(others[0])
        case inspect.VarTupleType(item_type=item):
            return st.lists(_of(item), max_size=3).map(tuple)
        case inspect.DictType(value_type=value):
            return st.dictionaries(_TEXT, _of(value), max_size=3)
        case inspect.EnumType(cls=cls):
            return st.sampled_from(list(cls))
        case inspect.LiteralType(values=values):
            return st.sampled_from(values)
        case inspect.RawType():
            return _RAW
        case inspect.BoolType():
            return st.booleans()
        case inspect.IntType():
            return _INT
        case inspect.FloatType():
            return _FLOAT
        case inspect.StrType():
            return _TEXT
        case _:
            raise NotImplementedError(f"no strategy for {kind}")

"""The schema check agrees with the jsonschema package wherever it does not refuse."""

from __future__ import annotations

from typing import Any

import jsonschema
import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wakeful.deliberation.schema import SchemaError, mismatch

VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats(-3, 3) | st.sampled_from(["", "a", "ab", "abc"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from("ab"), inner, max_size=2),
    max_leaves=6,
)


def _schemas(inner: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    names = st.sampled_from(["null", "boolean", "integer", "number", "string", "array", "object"])
    few = st.integers(0, 3)
    return st.fixed_dictionaries(
        {},
        optional={
            "type": names | st.lists(names, min_size=1, max_size=2, unique=True),
            "enum": st.lists(VALUES, min_size=1, max_size=3),
            "const": VALUES,
            "anyOf": st.lists(inner, min_size=1, max_size=2),
            "properties": st.dictionaries(st.sampled_from("ab"), inner, max_size=2),
            "required": st.lists(st.sampled_from("ab"), max_size=2, unique=True),
            "additionalProperties": st.booleans() | inner,
            "items": inner,
            "minimum": st.integers(-3, 3),
            "maximum": st.integers(-3, 3),
            "exclusiveMinimum": st.integers(-3, 3),
            "exclusiveMaximum": st.integers(-3, 3),
            "minLength": few,
            "maxLength": few,
            "minItems": few,
            "maxItems": few,
            "title": st.just("a title"),
        },
    )


SCHEMAS = st.recursive(st.just({}), _schemas, max_leaves=5)


@given(VALUES, SCHEMAS)
def test_it_says_what_jsonschema_says(value: Any, schema: Any) -> None:
    valid = jsonschema.Draft202012Validator(schema).is_valid(value)
    assert (mismatch(value, schema) is None) == valid


class Part(msgspec.Struct):
    name: str
    share: float


class Plan(msgspec.Struct):
    parts: list[Part]
    via: tuple[str, ...]
    first: Part | None = None
    limits: dict[str, int] = {}


PLAN = msgspec.json.schema(Plan)


def test_what_msgspec_writes_can_be_checked() -> None:
    fits = {"parts": [{"name": "a", "share": 0.5}], "via": ["b"], "first": None, "limits": {"a": 1}}
    assert mismatch(fits, PLAN) is None
    assert mismatch({**fits, "first": {"name": "a"}}, PLAN) is not None
    assert mismatch({**fits, "parts": [{"name": 1, "share": 0.5}]}, PLAN) == "$.parts[0].name is not of type string"
    assert mismatch({"via": []}, PLAN) == "$ lacks parts"
    assert mismatch({**fits, "limits": {"a": "b"}}, PLAN) == "$.limits.a is not of type integer"


@pytest.mark.parametrize(
    "schema",
    [
        {"pattern": "^a"},
        {"properties": {"a": {"not": {}}}},
        {"$ref": "#/$defs/nowhere"},
        {"type": "date"},
        {"enum": "abc"},
        7,
        {"$ref": "#"},
        {"$ref": "#/$defs/a", "$defs": {"a": {"$ref": "#/$defs/a"}}},
    ],
)
def test_a_schema_that_cannot_be_checked_is_refused_and_not_passed_over(schema: Any) -> None:
    with pytest.raises(SchemaError):
        mismatch({"a": 1}, schema)

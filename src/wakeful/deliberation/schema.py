"""Checks an answer against the part of JSON Schema that ``msgspec.json.schema`` writes."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TypeAlias

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.facts.values import Value

_DEEPEST = 40


class SchemaError(ReasonerError):
    """A question whose schema uses what this check does not know; the message names it. A check that skipped it would be none."""


class _Place(msgspec.Struct, frozen=True):
    """Where the check stands: the whole schema, the part that applies, the path of the value, how deep."""

    root: Mapping[str, Value]
    schema: Mapping[str, Value]
    path: str
    depth: int

    def inside(self, schema: Value, path: str) -> _Place:
        if not isinstance(schema, Mapping):
            raise SchemaError(f"the schema of {path} is not an object")
        return _Place(self.root, schema, path, self.depth + 1)


#: (value, the keyword's argument, where) -> what is wrong, or None.
_Rule: TypeAlias = Callable[[Value, Value, _Place], str | None]


def mismatch(value: Value, schema: Value) -> str | None:
    """What is wrong with a value, as one sentence, or None where it fits.

    Args:
        value: decoded JSON.
        schema: a decoded JSON schema.

    Raises:
        SchemaError: the schema uses a keyword that is not in RULES or ANNOTATIONS, or nests too deep.

    >>> mismatch({"speed": 3}, {"type": "object", "properties": {"speed": {"type": "number", "maximum": 2}}})
    '$.speed is more than 2'
    """
    if not isinstance(schema, Mapping):
        raise SchemaError("the schema is not an object")
    return _check(value, _Place(schema, schema, "$", 0))


def _check(value: Value, place: _Place) -> str | None:
    if place.depth > _DEEPEST:
        raise SchemaError(f"the schema or the answer nests more than {_DEEPEST} deep")
    for keyword, argument in place.schema.items():
        if keyword in ANNOTATIONS:
            continue
        if keyword not in RULES:
            raise SchemaError(f"the schema of {place.path} uses {keyword!r}, which is not checked here")
        wrong = RULES[keyword](value, argument, place)
        if wrong is not None:
            return wrong
    return None


def _same(left: Value, right: Value) -> bool:
    """Equality as JSON has it: 1 is 1.0, and neither is true."""
    if isinstance(left, list) and isinstance(right, list):
        return len(left) == len(right) and all(map(_same, left, right))
    if isinstance(left, dict) and isinstance(right, dict):
        return left.keys() == right.keys() and all(_same(left[name], right[name]) for name in left)
    return left == right and isinstance(left, bool) == isinstance(right, bool)


def _list(argument: Value, place: _Place) -> Sequence[Value]:
    if isinstance(argument, str) or not isinstance(argument, Sequence):
        raise SchemaError(f"the schema of {place.path} has something else where a list must be")
    return argument


def _is_type(value: Value, name: Value, place: _Place) -> bool:
    match name:
        case "null":
            return value is None
        case "boolean":
            return isinstance(value, bool)
        case "integer":
            return (isinstance(value, int) and not isinstance(value, bool)) or (isinstance(value, float) and value.is_integer())
        case "number":
            return isinstance(value, int | float) and not isinstance(value, bool)
        case "string":
            return isinstance(value, str)
        case "array":
            return isinstance(value, list)
        case "object":
            return isinstance(value, dict)
    raise SchemaError(f"the schema of {place.path} names the type {name!r}, which JSON does not have")


def _type(value: Value, argument: Value, place: _Place) -> str | None:
    names = (argument,) if isinstance(argument, str) else _list(argument, place)
    return None if any(_is_type(value, name, place) for name in names) else f"{place.path} is not of type {argument}"


def _enum(value: Value, argument: Value, place: _Place) -> str | None:
    allowed = _list(argument, place)
    return None if any(_same(value, one) for one in allowed) else f"{place.path} is not one of {list(allowed)}"


def _const(value: Value, argument: Value, place: _Place) -> str | None:
    return None if _same(value, argument) else f"{place.path} is not {argument!r}"


def _any_of(value: Value, argument: Value, place: _Place) -> str | None:
    wrongs = [_check(value, place.inside(one, place.path)) for one in _list(argument, place)]
    return None if None in wrongs else f"{place.path} fits none of its forms ({'; '.join(filter(None, wrongs))})"


def _reference(value: Value, argument: Value, place: _Place) -> str | None:
    found: Value = place.root
    for step in str(argument).removeprefix("#/").split("/"):
        found = found.get(step) if isinstance(found, Mapping) else None
    return _check(value, place.inside(found, place.path))


def _properties(value: Value, argument: Value, place: _Place) -> str | None:
    if not isinstance(value, dict) or not isinstance(argument, Mapping):
        return None
    wrongs = (_check(value[name], place.inside(one, f"{place.path}.{name}")) for name, one in argument.items() if name in value)
    return next(filter(None, wrongs), None)


def _required(value: Value, argument: Value, place: _Place) -> str | None:
    if not isinstance(value, dict):
        return None
    missing = [str(name) for name in _list(argument, place) if name not in value]
    return f"{place.path} lacks {', '.join(missing)}" if missing else None


def _additional(value: Value, argument: Value, place: _Place) -> str | None:
    if not isinstance(value, dict) or argument is True:
        return None
    declared = place.schema.get("properties", {})
    others = [name for name in value if not (isinstance(declared, Mapping) and name in declared)]
    if argument is False:
        return f"{place.path} has {', '.join(others)}, which is not declared" if others else None
    wrongs = (_check(value[name], place.inside(argument, f"{place.path}.{name}")) for name in others)
    return next(filter(None, wrongs), None)


def _items(value: Value, argument: Value, place: _Place) -> str | None:
    if not isinstance(value, list):
        return None
    fixed = len(_list(place.schema.get("prefixItems", ()), place))
    if argument is False:
        return f"{place.path} has more than {fixed} items" if len(value) > fixed else None
    wrongs = (_check(one, place.inside(argument, f"{place.path}[{at}]")) for at, one in enumerate(value) if at >= fixed)
    return next(filter(None, wrongs), None)


def _prefix(value: Value, argument: Value, place: _Place) -> str | None:
    if not isinstance(value, list):
        return None
    pairs = enumerate(zip(value, _list(argument, place), strict=False))
    return next(filter(None, (_check(one, place.inside(form, f"{place.path}[{at}]")) for at, (one, form) in pairs)), None)


def _bound(holds: Callable[[float, float], bool], says: str) -> _Rule:
    def rule(value: Value, argument: Value, place: _Place) -> str | None:
        if isinstance(value, bool) or not isinstance(value, int | float) or not isinstance(argument, int | float):
            return None
        return None if holds(value, argument) else f"{place.path} is {says} {argument}"

    return rule


def _length(kind: type[str] | type[list[Value]], holds: Callable[[float, float], bool], says: str) -> _Rule:
    def rule(value: Value, argument: Value, place: _Place) -> str | None:
        if not isinstance(value, kind) or not isinstance(argument, int | float):
            return None
        return None if holds(len(value), argument) else f"{place.path} is {says} than {argument}"

    return rule


#: Every keyword that is checked. One that is neither here nor in ANNOTATIONS makes the schema unusable, never lax.
RULES: dict[str, _Rule] = {
    "$ref": _reference,
    "type": _type,
    "enum": _enum,
    "const": _const,
    "anyOf": _any_of,
    "properties": _properties,
    "required": _required,
    "additionalProperties": _additional,
    "items": _items,
    "prefixItems": _prefix,
    "minimum": _bound(operator.ge, "less than"),
    "maximum": _bound(operator.le, "more than"),
    "exclusiveMinimum": _bound(operator.gt, "not more than"),
    "exclusiveMaximum": _bound(operator.lt, "not less than"),
    "minLength": _length(str, operator.ge, "shorter"),
    "maxLength": _length(str, operator.le, "longer"),
    "minItems": _length(list, operator.ge, "shorter"),
    "maxItems": _length(list, operator.le, "longer"),
}

#: Keywords that say nothing about what is valid.
ANNOTATIONS = frozenset({"$schema", "$id", "$defs", "$comment", "title", "description", "default", "examples", "format"})

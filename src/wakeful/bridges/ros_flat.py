"""Any ROS message as plain values under dotted names, within bounds."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any, Final, TypeAlias

import numpy as np

from wakeful.bridges.plain import plain, text
from wakeful.facts.values import Value

#: A decoded message, or a field of one.
Message: TypeAlias = Any

MAX_DEPTH: Final = 6
MAX_VALUES: Final = 128
MAX_ARRAY: Final = 16
MAX_MESSAGES: Final = 8


def flat(message: Message) -> dict[str, Value]:
    """The scalars, texts and short arrays of a message under dotted names.

    Six levels and 128 values at most; of an array of messages the first eight, with their number under ``name.count``; of an
    array of more than sixteen numbers or texts only the number. The header is left out: every observation has its time and frame.
    """
    values: dict[str, Value] = {}
    for name, value in _leaves("", message, 0):
        if len(values) >= MAX_VALUES:
            break
        values[name] = value
    return values


def _leaves(path: str, value: Message, depth: int) -> Iterator[tuple[str, Value]]:
    if is_dataclass(value):
        if depth >= MAX_DEPTH:
            return
        for field in fields(value):
            if field.name == "__msgtype__" or (depth == 0 and field.name == "header"):
                continue
            yield from _leaves(f"{path}.{field.name}" if path else field.name, getattr(value, field.name), depth + 1)
    elif isinstance(value, np.ndarray):
        yield from _array(path, value)
    elif isinstance(value, list | tuple):
        yield from _list(path, value, depth)
    elif isinstance(value, bytes):
        yield path, value[0] if len(value) == 1 else f"{len(value)} bytes"
    else:
        yield path, plain(value)


def _array(path: str, value: np.ndarray[Any, np.dtype[Any]]) -> Iterator[tuple[str, Value]]:
    if value.size <= MAX_ARRAY:
        yield path, plain(value.ravel().tolist())
    else:
        yield f"{path}.count", int(value.size)


def _list(path: str, items: list[Message] | tuple[Message, ...], depth: int) -> Iterator[tuple[str, Value]]:
    if items and is_dataclass(items[0]):
        yield f"{path}.count", len(items)
        for number, item in enumerate(items[:MAX_MESSAGES]):
            yield from _leaves(f"{path}.{number}", item, depth + 1)
    elif len(items) <= MAX_ARRAY:
        yield path, [text(item) if isinstance(item, str) else plain(item) for item in items]
    else:
        yield f"{path}.count", len(items)

"""Numbers as they come from the world: they may be missing, infinite, or no number at all."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite

from wakeful.contracts.detector import BOOKKEEPING
from wakeful.facts.domain import FieldSpec
from wakeful.facts.values import Field
from wakeful.treatments.wording import brief

#: Beyond this no sensor measures anything; such a value is treated as missing, so that squares and sums stay finite.
LARGEST = 1e30


#: Fields that say where a value comes from, not what is there: they are not compared.
ADDRESSES = frozenset(("channel", "topic"))


def number(value: object) -> float | None:
    """A finite number of believable size, else None. Booleans are no numbers here.

    >>> number(3), number(True), number(float("nan")), number("3")
    (3.0, None, None, None)
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, int) and abs(value) > LARGEST:
        return None
    return float(value) if isfinite(value) and abs(value) <= LARGEST else None


def numbers(fields: Mapping[str, Field]) -> dict[str, float]:
    """The fields that are numbers, in their order."""
    found = ((name, number(value)) for name, value in fields.items())
    return {name: value for name, value in found if value is not None}


def comparable(fields: Mapping[str, Field]) -> dict[str, Field]:
    """The fields that say what is there, in their order."""
    return {name: value for name, value in fields.items() if name not in ADDRESSES}


def measured(fields: Mapping[str, Field], specs: Mapping[str, FieldSpec]) -> dict[str, Field]:
    """The fields that were measured or seen, in their order: without a detector's book-keeping, unless the domain says otherwise.

    >>> measured({"value": 2.7, "usual": 0.1, "deviation": 20.3}, {})
    {'value': 2.7}
    """
    declared = {name: spec.compared for name, spec in specs.items() if spec.compared is not None}
    return {name: value for name, value in comparable(fields).items() if declared.get(name, name not in BOOKKEEPING)}


def plain(value: Field) -> Field:
    """The value as it can be recorded in JSON and read back the same: what is not finite becomes None, text is cut short."""
    if isinstance(value, tuple):
        return tuple(item for item in (number(each) for each in value) if item is not None)
    if isinstance(value, bool) or value is None:
        return value
    if isinstance(value, str):
        return brief(value)
    return number(value)


def significant(value: float, digits: int = 6) -> float:
    """``value`` to so many significant digits: what results carry.

    >>> significant(0.123456789), significant(1234567.0)
    (0.123457, 1234570.0)
    """
    return float(f"{value:.{digits}g}")

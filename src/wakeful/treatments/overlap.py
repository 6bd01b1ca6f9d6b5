"""How far two situations share their attributes.

Source: Gower 1971: the mean over attributes of 1 - |difference| / range for numbers and equality for the rest; an attribute
that only one of them has counts as not shared.
"""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.domain import FieldSpec
from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import comparable, number, plain, significant

#: From this agreement on an attribute counts as shared.
SHARED = 0.9


class Overlap(Fact, frozen=True):
    """The mean agreement in [0, 1], and the attributes by whether they are shared. ``lacking``: only one side has them."""

    share: float
    shared: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()
    lacking: tuple[str, ...] = ()


def overlap(a: Mapping[str, Field], b: Mapping[str, Field], specs: Mapping[str, FieldSpec]) -> Overlap:
    """How far the attributes agree; nothing on both sides is no agreement.

    >>> overlap({"state": "hot", "load": 0.5}, {"state": "hot", "load": 0.75}, {}).share
    0.833333
    """
    a, b = comparable(a), comparable(b)
    names = list(dict.fromkeys((*a, *b)))
    agreed = {name: _agreement(a[name], b[name], specs.get(name)) for name in names if name in a and name in b}
    return Overlap(
        share=significant(sum(agreed.values()) / len(names)) if names else 0.0,
        shared=tuple(name for name, share in agreed.items() if share >= SHARED),
        differing=tuple(name for name, share in agreed.items() if share < SHARED),
        lacking=tuple(name for name in names if name not in agreed),
    )


def _agreement(a: Field, b: Field, spec: FieldSpec | None) -> float:
    left, right = number(a), number(b)
    if left is None or right is None:
        return 1.0 if plain(a) == plain(b) else 0.0
    width = abs(spec.high - spec.low) if spec is not None and spec.high != spec.low else max(abs(left), abs(right))
    return max(1.0 - abs(left - right) / width, 0.0) if width > 0.0 else 1.0

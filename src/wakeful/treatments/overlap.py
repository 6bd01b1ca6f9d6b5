"""How far two situations share their attributes.

Source: Gower 1971: the mean over attributes of 1 - |difference| / range for numbers and equality for the rest; an attribute
that only one of them has counts as not shared.
"""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.asking import Episode
from wakeful.facts.domain import FieldSpec
from wakeful.facts.events import Event
from wakeful.facts.values import Fact, Field
from wakeful.treatments.measures import comparable, number, plain, significant

#: From this agreement on an attribute counts as shared.
SHARED = 0.9

#: How much words that were never met count as known ones, by meaning: field (``kind``: the event's) -> known word -> [0, 1].
Meanings = Mapping[str, Mapping[str, float]]
NO_MEANINGS: Meanings = {}


class Overlap(Fact, frozen=True):
    """The mean agreement in [0, 1], and the attributes by whether they are shared. ``lacking``: only one side has them."""

    share: float
    shared: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()
    lacking: tuple[str, ...] = ()

    @property
    def names(self) -> int:
        """How many attributes the two have between them."""
        return len(self.shared) + len(self.differing) + len(self.lacking)


def overlap(
    a: Mapping[str, Field], b: Mapping[str, Field], specs: Mapping[str, FieldSpec], meanings: Meanings = NO_MEANINGS
) -> Overlap:
    """How far the attributes agree; nothing on both sides is no agreement. Words agree as far as they mean the same, where that
    is known, else where they are the same.

    >>> overlap({"state": "hot", "load": 0.5}, {"state": "hot", "load": 0.75}, {}).share
    0.833333
    """
    a, b = comparable(a), comparable(b)
    names = list(dict.fromkeys((*a, *b)))
    agreed = {
        name: _meant(meanings, name, b[name], _agreement(a[name], b[name], specs.get(name)))
        for name in names
        if name in a and name in b
    }
    return Overlap(
        share=significant(sum(agreed.values()) / len(names)) if names else 0.0,
        shared=tuple(name for name, share in agreed.items() if share >= SHARED),
        differing=tuple(name for name, share in agreed.items() if share < SHARED),
        lacking=tuple(name for name in names if name not in agreed),
    )


def worth(event: Event, episode: Episode, specs: Mapping[str, FieldSpec], meanings: Meanings = NO_MEANINGS) -> float:
    """How much of a case a recalled one is for this event, in [0, 1]: the overlap squared, so that many cases that agree in
    little don't drown a few that agree in much; half of that where it is of another kind, more where the kinds mean the same.

    The search's likeness only says which cases to look at: its scale is that of the learner's features.
    """
    same_kind = event.kind == episode.kind
    shared = overlap(event.fields, episode.fields, specs, meanings)
    share = shared.share if shared.names else float(same_kind)
    nature = 1.0 if same_kind else meanings.get("kind", {}).get(episode.kind, 0.0)
    return significant(share**2 * (1.0 + nature) / 2.0)


def _meant(meanings: Meanings, name: str, value: Field, otherwise: float) -> float:
    return meanings[name].get(value, otherwise) if name in meanings and isinstance(value, str) else otherwise


def _agreement(a: Field, b: Field, spec: FieldSpec | None) -> float:
    if isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b) > 0:
        return sum(_agreement(left, right, spec) for left, right in zip(a, b, strict=True)) / len(a)
    left, right = number(a), number(b)
    if left is None or right is None:
        return 1.0 if plain(a) == plain(b) else 0.0
    width = scale(left, right, spec)
    return max(1.0 - abs(left - right) / width, 0.0) if width > 0.0 else 1.0


def scale(a: float, b: float, spec: FieldSpec | None) -> float:
    """What a difference of two numbers is measured by: the field's declared range if both lie in it, else the larger of them.

    >>> scale(20.0, 30.0, FieldSpec(low=0.0, high=100.0)), scale(20.0, 30.0, FieldSpec()), scale(-3.0, 2.0, None)
    (100.0, 30.0, 3.0)
    """
    if spec is not None and spec.low <= min(a, b) and max(a, b) <= spec.high:
        return spec.high - spec.low
    return max(abs(a), abs(b))

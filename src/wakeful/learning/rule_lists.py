"""Decision lists as one of a model's experts on treatments: many lists, each with its say, and what each said in words."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.grounds import Ask, HeardRule
from wakeful.learning.clauses import Clause, Clauses, as_arrays, as_bits
from wakeful.learning.material import Flags, Floats, Material
from wakeful.learning.rule_search import Listed, Search, SearchSettings

_TEMPER: Final = 9.0
"""A chain whose lists compress this many nats worse has a say that is e times smaller."""
_COPIES: Final = 3
_REMEMBERED: Final = 4096
_DIGITS = 9


class RuleLists(msgspec.Struct, frozen=True, kw_only=True):
    """Lists over shared clauses. ``lists`` holds rules as clause numbers in order; ``spoken`` (r, k) is what each rule of each
    list, and then its last resort, says of the k classes, list after list; ``support`` the rows that it speaks for; ``say``
    each list's share, which add up to 1."""

    clauses: tuple[Clause, ...]
    lists: tuple[tuple[tuple[int, ...], ...], ...]
    spoken: Floats
    support: tuple[int, ...]
    say: tuple[float, ...]


def fit_rules(rows: Material, held_back: Flags, classes: int, seed: int, settings: SearchSettings) -> tuple[RuleLists, RuleLists]:
    """Find lists for the rows whose treatment is known: first without those held back, then, going on from there, with them.

    A row that weighs twice as much as the middle one counts twice, three times at most. Without a labelled row there are no
    lists, and all classes are equally likely.

    Args:
        rows: what is known.
        held_back: which rows the first lists must not have seen.
        classes: how many treatments there are.
        seed: of the chains.
        settings: of the search.

    Returns:
        The lists that can be tested on what was held back, and those that have learned from all.
    """
    known = np.flatnonzero((rows.treatment >= 0) & (rows.weight > 0.0))
    even = np.full((1, classes), round(1.0 / classes, _DIGITS))
    blind = RuleLists(clauses=(), lists=((),), spoken=even, support=(0,), say=(1.0,))
    if not len(known):
        return blind, blind
    copies = np.clip(np.round(rows.weight[known] / float(np.median(rows.weight[known]))), 1, _COPIES).astype(np.int64)
    at = np.repeat(known, copies)
    treatment, kept = rows.treatment[at], held_back[at]
    present = [int(each) for each in np.unique(treatment)]
    bits = [as_bits(treatment == each) for each in present]
    clauses = Clauses(rows.x[at])
    everything = as_bits(np.ones(len(at), dtype=np.bool_))
    seeds = [seed * 1009 + chain for chain in range(settings.chains)]
    first = Search(clauses, bits, everything if kept.all() else as_bits(~kept), settings)
    found = [first.chain(each) for each in seeds]
    tested = blind if kept.all() else _kept(first, clauses, found, present, classes, settings)
    if not kept.any():
        return tested, tested
    whole = Search(clauses, bits, everything, settings)
    again = [whole.chain_from(lists[-1][1], each) for lists, each in zip(found, seeds, strict=True)]
    return tested, _kept(whole, clauses, again, present, classes, settings)


def _kept(
    search: Search,
    clauses: Clauses,
    chains: list[list[tuple[float, Listed]]],
    present: list[int],
    classes: int,
    settings: SearchSettings,
) -> RuleLists:
    """What the chains found, with what each rule says of the classes."""
    found = [(place, score, rules) for place, lists in enumerate(chains) for score, rules in lists]
    used = sorted({clause for _, _, rules in found for rule in rules for clause in rule})
    place_of = {clause: index for index, clause in enumerate(used)}
    spoken: list[Floats] = []
    support: list[int] = []
    for _, _, rules in found:
        for counts in search.counts(rules):
            shares: Floats = np.full(classes, settings.prior)
            shares[present] += counts
            spoken.append(shares / shares.sum())
            support.append(sum(counts))
    return RuleLists(
        clauses=tuple(clauses.clauses[clause] for clause in used),
        lists=tuple(tuple(tuple(place_of[clause] for clause in rule) for rule in rules) for _, _, rules in found),
        spoken=np.asarray(np.round(np.array(spoken, dtype=np.float64), _DIGITS), dtype=np.float64),
        support=tuple(support),
        say=_says([score for _, score, _ in found], [chain for chain, _, _ in found]),
    )


def _says(scores: list[float], chains: list[int]) -> tuple[float, ...]:
    """Each list's share: of its chain by the chain's mean score, evenly within it."""
    by_chain: dict[int, list[float]] = {}
    for chain, score in zip(chains, scores, strict=True):
        by_chain.setdefault(chain, []).append(score)
    means = {chain: sum(each) / len(each) for chain, each in by_chain.items()}
    best = max(means.values())
    weights = [math.exp((means[chain] - best) / _TEMPER) / len(by_chain[chain]) for chain in chains]
    return tuple(round(each / sum(weights), _DIGITS) for each in weights)


class RuleReader:
    """Reads lists for one event at a time: each different rule is asked once, of its own each list takes the first that holds."""

    def __init__(self, model: RuleLists) -> None:
        self._model = model
        self._columns, self._others, self._slopes, self._limits, self._above = as_arrays(model.clauses)
        self._oblique = bool(self._slopes.any())
        rules = list(dict.fromkeys(tuple(sorted(set(rule))) for each in model.lists for rule in each))
        number = {rule: place for place, rule in enumerate(rules)}
        self._wanted = np.zeros((len(model.clauses), len(rules) + 1))
        """By clause and rule whether the rule asks for the clause; the last rule, which asks for nothing, always holds."""
        for rule, place in number.items():
            self._wanted[list(rule), place] = 1.0
        longest = max((len(each) for each in model.lists), default=0)
        self._order = np.full((len(model.lists), longest + 1), len(rules), dtype=np.intp)
        for at, each in enumerate(model.lists):
            self._order[at, : len(each)] = [number[tuple(sorted(set(rule)))] for rule in each]
        self._start = np.cumsum([0, *(len(each) + 1 for each in model.lists[:-1])], dtype=np.intp)
        self._known: dict[bytes, Floats] = {}
        self._spoken = model.spoken * np.repeat(np.array(model.say), [len(each) + 1 for each in model.lists])[:, None]

    def shares(self, x: Floats) -> Floats:
        """Probabilities (k,) for one row (d,)."""
        return self._of(self._flags(x))

    def shares_many(self, x: Floats) -> Floats:
        """The same for rows, (n, k)."""
        flags = (x[:, self._columns] + self._slopes * x[:, self._others] > self._limits) == self._above
        holds = (~flags).astype(np.float64) @ self._wanted == 0.0
        first = self._start + holds[:, self._order].argmax(axis=2)
        return np.asarray(self._spoken[first].sum(axis=1))

    def speaking(self, x: Floats) -> list[int]:
        """Which rule of each list speaks for the row, as places in ``spoken``."""
        found: list[int] = self._first(self._flags(x)).tolist()
        return found

    def heard(self, x: Floats, place: int) -> tuple[HeardRule, ...]:
        """The different rules that speak for the row, the most heard first, and what each says of the class at ``place``.

        A list in which another one speaks may hold the same rule further down.
        """
        model = self._model
        found: dict[tuple[int, ...], list[tuple[float, float, int]]] = {}
        start = 0
        for say, rules, spoke in zip(model.say, model.lists, self.speaking(x), strict=True):
            rule = tuple(sorted(set(rules[spoke - start]))) if spoke - start < len(rules) else ()
            found.setdefault(rule, []).append((say, float(model.spoken[spoke, place]), model.support[spoke]))
            start += len(rules) + 1
        heard = [
            HeardRule(
                asks=tuple(self._ask(model.clauses[clause]) for clause in rule),
                heard=round(sum(say for say, _, _ in said), _DIGITS),
                share=round(sum(say * share for say, share, _ in said) / sum(say for say, _, _ in said), _DIGITS),
                support=max(support for _, _, support in said),
            )
            for rule, said in found.items()
            if sum(say for say, _, _ in said) > 0.0
        ]
        return tuple(sorted(heard, key=lambda each: -each.heard))

    @staticmethod
    def _ask(clause: Clause) -> Ask:
        return Ask(column=clause.column, limit=clause.limit, above=clause.above, other=clause.other, slope=clause.slope)

    def _flags(self, x: Floats) -> Flags:
        """Which clauses hold of one row."""
        values = x.take(self._columns)
        if self._oblique:
            values = values + self._slopes * x.take(self._others)
        return np.asarray((values > self._limits) == self._above)

    def _of(self, flags: Flags) -> Floats:
        key = flags.tobytes()
        found = self._known.get(key)
        if found is None:
            found = np.asarray(self._spoken.take(self._first(flags), axis=0).sum(axis=0))
            if len(self._known) < _REMEMBERED:
                self._known[key] = found
        return found

    def _first(self, flags: Flags) -> npt.NDArray[np.intp]:
        """For each list the first of its rules that holds, as places in ``spoken``."""
        holds = (~flags).astype(np.float64) @ self._wanted == 0.0
        return np.asarray(self._start + holds.take(self._order).argmax(axis=1))

"""The search for decision lists: ordered rules, of which the first that holds speaks, else the last, which always does.

A list's score is the logarithm of how well it compresses what was learned: the marginal likelihood of the classes under each rule
(Dirichlet-multinomial, as in Bayesian rule lists: Letham, Rudin, McCormick and Madigan 2015), less the cost of naming its
clauses. A limit that another rule has named already costs little, so that what is one boundary in the world is learned as one.
Lists are found by annealing: each step changes one rule in all ways of one kind and draws among them by score.
"""

from __future__ import annotations

from math import exp, lgamma, log
from random import Random
from typing import Final

import msgspec

from wakeful.learning.clauses import Clauses

Rule = tuple[int, ...]
"""Numbers of clauses that must all hold."""
Listed = tuple[Rule, ...]

_SHARED_LIMIT = 2.5
_PER_RULE = 1.0
_USELESS = -3.0
_LONGEST = 4
_GROW: Final = (1, 2, 2, 3, 3)
_REMEMBERED = 200_000


class SearchSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """``chains`` are annealed apart, from ``heat`` down to 1 over the ``settled`` part of ``steps``; the ``kept`` lists of each
    are drawn from the rest. ``steps_again`` and ``heat_again`` are those of a chain that goes on from a list. ``prior`` is how
    often each class counts as seen in advance, ``terse`` what a nat of naming weighs."""

    chains: int = 6
    steps: int = 1200
    heat: float = 6.0
    steps_again: int = 400
    heat_again: float = 2.0
    settled: float = 0.6
    kept: int = 5
    prior: float = 0.1
    terse: float = 0.7


class _Found(msgspec.Struct, frozen=True):
    """A list with the rows that each rule asks for, and its score."""

    score: float
    rules: Listed
    masks: tuple[int, ...]


class Search:
    """One problem to find lists for.

    Args:
        clauses: what may be asked of the rows.
        classes: for each class the rows that are of it, as bits.
        rows: the rows that are learned from, as bits.
        settings: how long and how.
    """

    def __init__(self, clauses: Clauses, classes: list[int], rows: int, settings: SearchSettings) -> None:
        self._clauses, self._all = clauses, rows
        self._classes = [bits & rows for bits in classes]
        self._settings = settings
        self._rows = [row for row in range(rows.bit_length()) if rows >> row & 1]
        self._class_of = {row: next(k for k, bits in enumerate(classes) if bits >> row & 1) for row in self._rows}
        a, k, most = settings.prior, len(classes), len(self._rows)
        self._seen = [lgamma(count + a) - lgamma(a) for count in range(most + 1)]
        self._total = [lgamma(k * a) - lgamma(count + k * a) for count in range(most + 1)]
        self._evidence: dict[int, float] = {0: _USELESS}

    def chain(self, seed: int) -> list[tuple[float, Listed]]:
        """The lists of one annealed chain, with their scores. The same seed gives the same lists."""
        own = self._settings
        return _Chain(self, Random(seed), ()).run(own.steps, own.heat)

    def chain_from(self, rules: Listed, seed: int) -> list[tuple[float, Listed]]:
        """The same from a list that was found on fewer rows: shorter, and less heated."""
        own = self._settings
        return _Chain(self, Random(seed), rules).run(own.steps_again, own.heat_again)

    def counts(self, rules: Listed) -> list[tuple[int, ...]]:
        """For each rule, and for what is left, how many rows of each class it speaks for."""
        left, found = self._all, []
        for mask in (*(self.mask(rule) for rule in rules), self._all):
            own = left & mask
            found.append(tuple((own & bits).bit_count() for bits in self._classes))
            left &= ~mask
        return found

    def mask(self, rule: Rule) -> int:
        """The rows of which all the rule's clauses hold."""
        mask = self._all
        for clause in rule:
            mask &= self._clauses.bits[clause]
        return mask

    def likelihood(self, masks: tuple[int, ...], left: int) -> float:
        """The evidence of rules that speak in turn for the rows that are left. A rule that is never heard costs."""
        known, total = self._evidence, 0.0
        for mask in masks:
            own = left & mask
            found = known.get(own)
            total += self._of(own) if found is None else found
            left ^= own
        return total + self._of(left) if left else total

    def before(self, masks: tuple[int, ...]) -> tuple[float, int]:
        """The evidence of the first rules without what is left, and what is left."""
        left = self._all
        total = 0.0
        for mask in masks:
            own = left & mask
            total += self._of(own)
            left ^= own
        return total, left

    def cost(self, rules: Listed) -> float:
        """What it takes to name the list."""
        total = 0.0
        limits: set[tuple[int, int, float]] = set()
        for rule in rules:
            total += _PER_RULE
            for clause in rule:
                total += self.naming(clause, limits)
                if self._clauses.limited[clause]:
                    limits.add(self._clauses.same_limit(clause))
        return self._settings.terse * total

    def naming(self, clause: int, limits: set[tuple[int, int, float]]) -> float:
        """What it takes to name a clause beside these limits."""
        known = self._clauses.limited[clause] and self._clauses.same_limit(clause) in limits
        return _SHARED_LIMIT if known else self._clauses.costs[clause]

    def found(self, rules: Listed, masks: tuple[int, ...]) -> _Found:
        """A list with its score."""
        return _Found(self.likelihood(masks, self._all) - self.cost(rules), rules, masks)

    def _of(self, rows: int) -> float:
        found = self._evidence.get(rows)
        if found is None:
            total, seen = 0, 0.0
            for bits in self._classes:
                count = (rows & bits).bit_count()
                if count:
                    total += count
                    seen += self._seen[count]
            if len(self._evidence) > _REMEMBERED:
                self._evidence.clear()
                self._evidence[0] = _USELESS
            found = self._evidence[rows] = seen + self._total[total]
        return found


class _Chain:
    """One annealed chain: a list that is changed step by step."""

    def __init__(self, search: Search, random: Random, rules: Listed) -> None:
        self._search, self._random = search, random
        self._clauses = search._clauses
        self._settings = search._settings
        self._now = search.found(rules, tuple(search.mask(rule) for rule in rules))

    def run(self, steps: int, hottest: float) -> list[tuple[float, Listed]]:
        """Anneal, then keep lists at even distances."""
        own = self._settings
        cooling = max(1, int(steps * own.settled))
        every = max(1, (steps - cooling) // own.kept)
        kept: list[tuple[float, Listed]] = []
        for step in range(steps):
            heat = max(1.0, hottest * (1.0 - step / cooling))
            self._now = self._drawn(self._change(), heat)
            if step >= cooling and (step - cooling) % every == every - 1 and len(kept) < own.kept:
                kept.append((self._now.score, self._now.rules))
        return kept or [(self._now.score, self._now.rules)]

    def _change(self) -> list[_Found]:
        kind, now = self._random.random(), self._now
        if kind < 0.35 or not now.rules:
            return self._grown()
        if kind < 0.55:
            return self._moved()
        if kind < 0.65:
            return self._shifted()
        return self._replaced()

    def _grown(self) -> list[_Found]:
        """A new rule for one row, preferably one that is now misunderstood: at every place, and in place of every rule."""
        search, random, now = self._search, self._random, self._now
        row = self._row()
        place = random.randrange(len(now.rules) + 1)
        _, left = search.before(now.masks[:place])
        if not left >> row & 1:
            left = search._all
        own = search._classes[search._class_of[row]]
        rule: Rule = ()
        mask = search._all
        for _ in range(random.choice(_GROW)):
            asked = {self._clauses.subject[clause] for clause in rule}
            candidates = [
                clause
                for clause in (*self._clauses.plain, *self._limited(8, row))
                if self._clauses.bits[clause] >> row & 1 and self._clauses.subject[clause] not in asked
            ]
            if len(candidates) > 10 and random.random() < 0.5:
                candidates = random.sample(candidates, len(candidates) // 2)
            if not candidates:
                break
            weights = []
            for clause in candidates:
                covered = left & mask & self._clauses.bits[clause]
                right = (covered & own).bit_count()
                weights.append(right * (1.5 + log((right + 0.1) / (covered.bit_count() + 0.6))))
            clause = candidates[self._draw(weights, 2.0)]
            rule, mask = (*rule, clause), mask & self._clauses.bits[clause]
        found = [now]
        for at in range(len(now.rules) + 1):
            found.append(search.found((*now.rules[:at], rule, *now.rules[at:]), (*now.masks[:at], mask, *now.masks[at:])))
        for at in range(len(now.rules)):
            found.append(
                search.found((*now.rules[:at], rule, *now.rules[at + 1 :]), (*now.masks[:at], mask, *now.masks[at + 1 :]))
            )
        return found

    def _moved(self) -> list[_Found]:
        """One rule left out, or at any other place."""
        now, at = self._now, self._random.randrange(len(self._now.rules))
        rules, masks = now.rules[:at] + now.rules[at + 1 :], now.masks[:at] + now.masks[at + 1 :]
        found = [self._search.found(rules, masks)]
        for to in range(len(now.rules)):
            found.append(self._search.found((*rules[:to], now.rules[at], *rules[to:]), (*masks[:to], now.masks[at], *masks[to:])))
        return found

    def _shifted(self) -> list[_Found]:
        """One limit elsewhere, wherever it is used, or another one in its place."""
        now, clauses = self._now, self._clauses
        used = [clause for rule in now.rules for clause in rule if clauses.limited[clause]]
        if not used:
            return self._moved()
        clause = self._random.choice(used)
        steps = (-8, -5, -3, -2, -1, 1, 2, 3, 5, 8)
        others = [other for each in steps if (other := clauses.shifted(clause, each)) is not None]
        for other in self._limited(6):
            others.append(other if clauses.clauses[other].above == clauses.clauses[clause].above else clauses.negated(other))
        inverse = clauses.negated(clause)
        found = [now]
        for other in others:
            change = {clause: other, inverse: clauses.negated(other)}
            rules = tuple(tuple(change.get(each, each) for each in rule) for rule in now.rules)
            masks = tuple(
                mask if rule == old else self._search.mask(rule)
                for rule, old, mask in zip(rules, now.rules, now.masks, strict=True)
            )
            found.append(self._search.found(rules, masks))
        return found

    def _replaced(self) -> list[_Found]:
        """One clause of one rule left out, added, or replaced by any other."""
        search, clauses, now = self._search, self._clauses, self._now
        at = self._random.randrange(len(now.rules))
        rule = now.rules[at]
        slot = self._random.randrange(len(rule) + 1)
        rest = rule[:slot] + rule[slot + 1 :]
        mask = search.mask(rest)
        first, left = search.before(now.masks[:at])
        found = [now]

        def put(new: Rule, covers: int, cost: float) -> None:
            masks = (*now.masks[:at], covers, *now.masks[at + 1 :])
            score = first + search.likelihood(masks[at:], left) - cost
            found.append(_Found(score, (*now.rules[:at], new, *now.rules[at + 1 :]), masks))

        others = (*now.rules[:at], rest, *now.rules[at + 1 :])
        cost = search.cost(others)
        if rest:
            put(rest, mask, cost)
        if len(rest) < _LONGEST:
            asked = {clauses.subject[clause] for clause in rest}
            limits = {clauses.same_limit(clause) for each in others for clause in each if clauses.limited[clause]}
            for clause in (*clauses.plain, *self._limited(12)):
                covers = mask & clauses.bits[clause]
                if clauses.subject[clause] not in asked and covers & left:
                    put((*rest, clause), covers, cost + self._settings.terse * search.naming(clause, limits))
        return found

    def _row(self) -> int:
        """A row to make a rule for: twice in three times one that its present rule doesn't expect."""
        search, left, wrong = self._search, self._search._all, 0
        for mask in (*self._now.masks, search._all):
            own = left & mask
            left &= ~mask
            expected = max(search._classes, key=lambda bits: (own & bits).bit_count())
            wrong |= own & ~expected
        if wrong and self._random.random() < 0.7:
            return self._random.choice([row for row in search._rows if wrong >> row & 1])
        return self._random.choice(search._rows)

    def _limited(self, count: int, row: int | None = None) -> list[int]:
        """Limited clauses to try: those in use with their negations, and some at random (that hold of the row)."""
        clauses, random = self._clauses, self._random
        used = {clause for rule in self._now.rules for clause in rule if clauses.limited[clause]}
        found = sorted(used | {clauses.negated(clause) for clause in used})
        axes, oblique = clauses.projections
        for _ in range(count if axes else 0):
            projection = random.randrange(axes) if not oblique or random.random() < 0.5 else axes + random.randrange(oblique)
            if row is None:
                clause = clauses.limited_clause(projection, random.random(), random.random() < 0.5)
            else:
                clause = clauses.through(projection, random.random(), row)
            if clause is not None:
                found.append(clause)
        return found

    def _drawn(self, found: list[_Found], heat: float) -> _Found:
        return found[self._draw([each.score for each in found], heat)]

    def _draw(self, scores: list[float], heat: float) -> int:
        """A place, with probability in proportion to exp(score / heat)."""
        highest = max(scores)
        weights = [exp(max(-60.0, (score - highest) / heat)) for score in scores]
        at = self._random.random() * sum(weights)
        for place, weight in enumerate(weights):
            at -= weight
            if at <= 0.0:
                return place
        return len(scores) - 1

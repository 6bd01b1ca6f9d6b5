"""A world of simulated deployments whose true risk is known, and the gates that live in it side by side."""

from __future__ import annotations

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.learning.calibration import CANDIDATES, POOLED, Marks, choose_thresholds
from wakeful.selection.guarantee import GuaranteeSettings
from wakeful.selection.guarantee.bets import LEVELS, place_of
from wakeful.selection.guarantee.evidence import Evidence

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.int64]

WRONG_AFTER = 0.6
"""After the change every answer is wrong with at least this probability, whatever its score."""
SEEN_WRONG, SEEN_RIGHT = 0.3, 0.6
"""How often the outcome of an automatic answer is seen that nobody asked for: failures less than successes."""
UNTOLD = 0.002
"""How often the outcome of a drawn event is never told."""
_WARM = 200
_GRID = 4000


class World(msgspec.Struct):
    """One treatment each: how much too sure its model is, and after how many events an outcome is known."""

    factor: Floats
    delay: Ints
    random: np.random.Generator

    @classmethod
    def make(cls, deployments: int, seed: int) -> World:
        """Factors from 0.6 (too modest) to 2.2 (far too sure), delays of 10 to 60 events."""
        random = np.random.default_rng(seed)
        return cls(random.uniform(0.6, 2.2, deployments), random.integers(10, 61, deployments), random)

    def scores(self, events: int) -> Floats:
        """Scores, (events, deployments): mostly high, with a long tail."""
        return 1.0 - self.random.beta(0.6, 2.4, (events, len(self.factor)))

    def wrong(self, scores: Floats, changed: bool) -> Floats:
        """P(wrong | score), by deployment."""
        before = np.minimum(1.0, self.factor * (1.0 - scores) + 0.005)
        return np.maximum(before, WRONG_AFTER) if changed else before

    def risk(self, limits: Floats, changed: bool) -> tuple[Floats, Floats]:
        """The true P(wrong and automatic) and P(automatic) of automating scores from the limits (deployments, k) on."""
        drawn = np.sort(1.0 - np.random.default_rng(1).beta(0.6, 2.4, 100 * _GRID))[50::100, None]
        wrong = self.wrong(drawn, changed)
        risk, share = np.zeros(limits.shape), np.zeros(limits.shape)
        for k in range(limits.shape[1]):
            inside = drawn >= limits[:, k]
            risk[:, k], share[:, k] = (wrong * inside).mean(axis=0), inside.mean(axis=0)
        return risk, share


class Lived(msgspec.Struct):
    """What came of one gate, an entry for each deployment. Errors are wrong automatic answers.

    ``above``: the true risk of the rule in force was above α at some time before the change; ``realised``: the share of errors
    in all events so far was, at some time from event 200 to the change. ``automatic``: the share in the last quarter before the
    change. ``first``: the event from which on it was automatic, -1 for never. ``at_change``: it was automatic when the change
    came, and the change was of the declared size at least. ``delay``: events from the change to revocation, -1 for never.
    ``after``: errors from the change to revocation or the end; ``allowed``: how many α would allow in as many events.
    """

    name: str
    above: Flags
    realised: Flags
    automatic: Floats
    first: Ints
    revoked_before: Ints
    at_change: Flags
    delay: Ints
    after: Ints
    allowed: Floats


def guarded(world: World, settings: GuaranteeSettings, events: int, name: str, audits: bool = True) -> Lived:
    """The guarantee gate. Without ``audits`` what is seen by itself is taken for a sample, which it is not.

    An answer that was right shows itself only when its window closes, ``delay`` events later: as evidence is taken up in the
    order of decisions, each event's turn comes then.
    """
    n, change, random = len(world.factor), events // 2, world.random
    rows, zeros = np.arange(n), np.zeros(n, dtype=np.int64)
    limits = np.broadcast_to(np.array(LEVELS), (n, len(LEVELS)))
    risk, later = world.risk(limits, False)[0], world.risk(limits, True)[0]
    scores = world.scores(events)
    places = place_of(scores)
    evidence = Evidence(settings, (n,))
    automatic, drawn, wrong, counts = (np.zeros((events, n), dtype=np.bool_) for _ in range(4))
    above, realised, at_change = (np.zeros(n, dtype=np.bool_) for _ in range(3))
    level, errors, after, late, false_alarms = (zeros.copy() for _ in range(5))
    first, delay = zeros - 1, zeros - 1
    for at in range(events):
        on, place = level > 0, np.maximum(level - 1, 0)
        inside = places[at] < level
        failed = random.random(n) < world.wrong(scores[at], at >= change)
        errors += inside & failed
        if at < change:
            above |= on & (risk[rows, place] > settings.alpha)
            realised |= (errors > settings.alpha * (at + 1)) & (at >= _WARM)
            late += inside & (at >= change - change // 4)
        else:
            if at == change:
                at_change = on & (later[rows, place] >= settings.to)
            after += inside & failed & (delay < 0)
        asked = ~inside | (random.random(n) < settings.audit_rate)
        told = asked & (random.random(n) >= UNTOLD)
        noticed = ~inside | (random.random(n) < np.where(failed, SEEN_WRONG, SEEN_RIGHT))
        automatic[at], drawn[at] = inside, asked if audits else noticed
        counts[at] = True if audits else noticed
        wrong[at] = np.where(told | noticed, failed, asked) if audits else failed
        turn, settled = np.maximum(at - world.delay, 0), at >= world.delay
        then = (turn, rows)
        rare = automatic[then] if audits else np.zeros(n, dtype=np.bool_)
        for probability, where in ((1.0, ~rare), (settings.audit_rate, rare)):
            evidence.take(
                places[then], drawn[then], wrong[then], automatic[then], probability, on, where & settled & counts[then]
            )
        revoked = on & np.logical_or(*evidence.alarms())
        if revoked.any():
            evidence.restart(revoked)
            counts[:, revoked] = False
            false_alarms += revoked & (at < change)
            delay = np.where(revoked & (at >= change) & (delay < 0), at - change + 1, delay)
        level = np.where(revoked, 0, np.maximum(level, evidence.weigh()))
        first = np.where((first < 0) & (level > 0), at, first)
    lasted = np.where(delay >= 0, delay, events - change)
    share = late / (change // 4)
    return Lived(name, above, realised, share, first, false_alarms, at_change, delay, after, settings.alpha * lasted)


def thresholded(world: World, settings: GuaranteeSettings, events: int, calibration: int, strict: bool) -> Lived:
    """The paper's rule: a threshold from 0.45 … 0.90, chosen on a calibration set whose outcomes are all known, then frozen.

    ``strict``: the product's own choice, which wants few errors among what passes. Otherwise the least threshold at which no
    more than α of the calibration set was wrong and passed: the same risk as the guarantee's, without its bound.
    """
    n, change, random = len(world.factor), events // 2, world.random
    scores = world.scores(calibration)
    failed = random.random(scores.shape) < world.wrong(scores, False)
    rule = _few_wrong_of_passing if strict else _few_wrong_of_all
    chosen = np.array([rule(scores[:, each], failed[:, each], settings.alpha) for each in range(n)])[:, None]
    (risk, share), (later, _) = world.risk(chosen, False), world.risk(chosen, True)
    on = share[:, 0] > 0.0
    runs = random.random((change, n)) < risk[:, 0]
    realised = (runs.cumsum(axis=0) > settings.alpha * np.arange(1, change + 1)[:, None])[_WARM:].any(axis=0)
    return Lived(
        f"threshold, {'few wrong of what passes' if strict else 'P(wrong and automatic) ≤ α'} on {calibration} events",
        risk[:, 0] > settings.alpha,
        realised,
        share[:, 0],
        np.where(on, 0, -1),
        np.zeros(n, dtype=np.int64),
        on & (later[:, 0] >= settings.to),
        np.full(n, -1),
        random.binomial(events - change, later[:, 0]),
        np.full(n, settings.alpha * (events - change)),
    )


def _few_wrong_of_all(scores: Floats, failed: Flags, alpha: float) -> float:
    return next((each for each in CANDIDATES if float((failed & (scores >= each)).mean()) <= alpha), 2.0)


def _few_wrong_of_passing(scores: Floats, failed: Flags, alpha: float) -> float:
    n = len(scores)
    marks = Marks(
        chosen=np.zeros(n, dtype=np.int64),
        confidence=np.round(scores, 6),
        result_confidence=np.ones(n),
        treatment_wrong=failed,
        result_wrong=np.zeros(n, dtype=np.bool_),
        judged=np.ones(n, dtype=np.bool_),
    )
    return choose_thresholds(marks, ("treatment",), alpha).get(POOLED, 2.0)

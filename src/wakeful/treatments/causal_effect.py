"""What the journal's own history says of one causal arrow: how often the effect followed, and how often it comes anyway."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import exp, inf

from wakeful.facts.events import Event
from wakeful.facts.values import Fact
from wakeful.treatments.beta import Belief
from wakeful.treatments.causal_graph import Arrow, confounders
from wakeful.treatments.measures import significant
from wakeful.treatments.remembering import NOTHING_RECALLED, Recalled, age_s


class Effect(Fact, frozen=True):
    """What the journal's own history says of one arrow: how often the effect followed, and how often it comes without."""

    followed: int
    cases: int
    strength: float
    low: float
    high: float
    base_rate: float | None = None
    """Probability that the effect appears in such a window anyway; None where too little was seen."""
    necessity: float | None = None
    """Probability that the effect would not have come without the cause: excess risk ratio, if identified."""
    identified: bool = False
    because: str = ""


def effect_of(
    event: Event,
    arrow: Arrow,
    arrows: Sequence[Arrow],
    seen: Mapping[str, Recalled],
    effects: Recalled,
    arrow_cases: float,
    least_cases: int,
) -> Effect:
    """The arrow's strength after what was recalled, and the probability of necessity where it is identified.

    Args:
        event: what is to be explained.
        arrow: the arrow in question, of ``arrows``.
        seen: what was recalled of each kind of cause.
        effects: what was recalled of the event's own kind.
        arrow_cases: how many cases the arrow's written strength weighs.
        least_cases: how many must have been seen before anything is estimated.

    Source: probability of necessity as the excess risk ratio, valid under exogeneity and monotonicity (Tian and Pearl 2000).
    """
    before = seen.get(arrow.cause, NOTHING_RECALLED)
    after = seen.get(arrow.effect, NOTHING_RECALLED) if arrow.effect != event.kind else effects
    # beyond what both recalls reach, a cause would seem to have had no effect, or an effect no cause
    reach_s = min(before.reach_s, after.reach_s)
    causes = [at for at in (age_s(event, episode) for episode in before.episodes) if at <= reach_s]
    times = [at for at in (age_s(event, episode) for episode in after.episodes) if at <= reach_s]
    # this event is no case of its own: it is what is to be explained
    past = [at for at in causes if at > arrow.within_s]
    followed = sum(1 for at in past if any(0.0 < at - then <= arrow.within_s for then in times))
    belief = Belief.of(arrow.strength, arrow_cases).after(followed, len(past) - followed)
    low, high = belief.interval()
    base = _base_rate(times, causes, arrow.within_s, least_cases)
    open_doors = confounders(arrows, arrow.cause, arrow.effect)
    why = ""
    if open_doors:
        why = f"unidentified: {', '.join(open_doors)} may cause both"
    elif len(past) < least_cases:
        why = f"unidentified: only {len(past)} earlier cases; the strength is the written one"
    elif base is None:
        why = "unidentified: how often the effect comes without the cause was not seen"
    return Effect(
        followed=followed,
        cases=len(past),
        strength=significant(belief.mean),
        low=low,
        high=high,
        base_rate=None if base is None else significant(base),
        necessity=None if why or base is None else significant(max(1.0 - base / belief.mean, 0.0)),
        identified=not why,
        because=why or "identified if the causal graph is right and the cause never prevents the effect",
    )


def _base_rate(times: Sequence[float], causes: Sequence[float], within_s: float, least: int) -> float | None:
    """P(effect in a window without the cause before it), from the rate of effects that no cause precedes."""
    if len(times) < least:
        return None
    alone = [then for then in times if not any(0.0 < at - then <= within_s for at in causes)]
    oldest_s, newest_s = max((*times, *causes)), min((*times, *causes))
    # time that lies in some cause's window is not time without it
    free_s = oldest_s - newest_s - _covered_s(causes, within_s, newest_s)
    return 1.0 - exp(-len(alone) * within_s / free_s) if free_s > within_s else None


def _covered_s(causes: Sequence[float], within_s: float, newest_s: float) -> float:
    """How much of the time until ``newest_s`` lies in some cause's window; what lies in several of them counts once.

    >>> _covered_s((100.0, 95.0, 10.0), 20.0, 0.0)
    35.0
    """
    covered_s = 0.0
    reached_s = inf
    for at in sorted(causes, reverse=True):  # ages: the oldest first
        until_s = max(at - within_s, newest_s)
        covered_s += max(min(at, reached_s) - until_s, 0.0)
        reached_s = until_s
    return covered_s

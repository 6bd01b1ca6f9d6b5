"""What can be said of each treatment's guarantee at this moment, as numbers and in a sentence."""

from __future__ import annotations

from typing import Literal

from wakeful.facts.values import Fact
from wakeful.selection.guarantee.guarantee import Guarantee
from wakeful.selection.guarantee.standing import NOTHING, Standing
from wakeful.selection.guarantee.watch import excess_bound

State = Literal["certified", "not yet", "revoked"]

_DIGITS = 6


class Conditional(Fact, frozen=True):
    """P(wrong | automatic), on automatic events that were drawn blindly: ``share`` of ``cases``, at most ``upper``.

    The upper bound is Clopper and Pearson's, for one look at these cases, at the same δ.
    """

    cases: int
    wrong: int
    share: float
    upper: float


class Report(Fact, frozen=True):
    """One treatment. Shares of events are of those that could be automatic; validated ones are shares of the automatic.

    ``bound``: P(wrong and automatic) is at most that, at every time at once, with probability 1 − δ: at the level in force, or at
    the strictest where none is. ``events``, ``drawn`` and ``errors`` are the evidence on ``model`` since it began or was revoked.
    ``needed``: so many more without an error certify the next level. ``delay_events``: as many awaited outcomes at once.
    ``may_cost``: B, so many automatic errors at most come after a change of the declared size before revocation, with probability
    1 − δ; None where nothing is certified.
    """

    treatment: str
    state: State
    says: str
    alpha: float
    delta: float
    bound: float
    level: float | None
    model: int
    number: int
    events: int
    drawn: int
    errors: int
    needed: int
    decided: int
    automatic: int
    share_automatic: float
    share_validated: float
    share_never_validated: float
    awaiting: int
    unknown: int
    delay_events: int
    may_cost: int | None = None
    conditional: Conditional | None = None


def report(guarantee: Guarantee) -> list[Report]:
    """Every treatment of which anything was decided under the guarantee, by name."""
    return [_of(name, standing) for name, standing in sorted(guarantee.standings.items())]


def _of(treatment: str, standing: Standing) -> Report:
    counted = standing.counted
    state: State = "certified" if standing.level < NOTHING else "revoked" if standing.revoked else "not yet"
    never = counted.automatic - counted.validated - counted.awaiting
    rate = standing.conditional
    return Report(
        treatment=treatment,
        state=state,
        says=_says(state, standing),
        alpha=standing.settings.alpha,
        delta=standing.settings.delta,
        bound=round(standing.bound, _DIGITS),
        level=standing.level if state == "certified" else None,
        model=standing.model,
        number=standing.number,
        events=standing.events,
        drawn=standing.known,
        errors=standing.errors_now,
        needed=standing.needed,
        decided=counted.decided,
        automatic=counted.automatic,
        share_automatic=_share(counted.automatic, counted.decided),
        share_validated=_share(counted.validated, counted.automatic),
        share_never_validated=_share(never, counted.automatic),
        awaiting=counted.awaiting,
        unknown=counted.unknown,
        delay_events=standing.waiting.longest,
        may_cost=_cost(standing) if state == "certified" else None,
        conditional=None
        if rate is None
        else Conditional(
            cases=counted.audited, wrong=counted.audited_wrong, share=round(rate[0], _DIGITS), upper=round(rate[1], _DIGITS)
        ),
    )


def _cost(standing: Standing) -> int:
    own = standing.settings
    return excess_bound(own.alpha, own.to, own.audit_rate, standing.waiting.longest, own.patience, own.delta)


def _says(state: State, standing: Standing) -> str:
    if state == "certified":
        looser = f"; {standing.needed:,} more without an error would loosen it" if standing.needed else ""
        cost = f"; a change may cost {_cost(standing):,} errors"
        return f"certified for scores from {standing.level:.2f} on, model version {standing.model}{looser}{cost}"
    needs = f"needs {standing.needed:,} more events without an error"
    if state == "revoked":
        return f"revoked: {standing.revoked}; {needs}"
    return f"not yet: model version {standing.model} {needs}" if standing.model else "not yet: no model has learned enough"


def _share(part: int, whole: int) -> float:
    return round(part / whole, _DIGITS) if whole else 0.0

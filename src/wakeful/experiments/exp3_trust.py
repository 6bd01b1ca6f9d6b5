"""How belief in a changed outcome moves, repetition by repetition: does it thrash, does it lock in an error?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from statistics import fmean

from wakeful.experiments.exp3_baselines import Said
from wakeful.experiments.worlds.service_drift import DriftWorld
from wakeful.facts.values import Fact


class Course(Fact, frozen=True):
    """One changed signature on one world; tuples are by repetition.

    ``outcome`` holds since the change, ``said`` is what was forecast, ``told`` what its validation told. ``known`` says how many
    of the earlier repetitions' validations were there, ``trust`` the probability that was given to the outcome that holds.
    """

    signature: str
    outcome: int
    said: tuple[int, ...]
    told: tuple[int, ...]
    known: tuple[int, ...]
    trust: tuple[float | None, ...]

    @property
    def swings(self) -> int:
        """How often the forecast changed, beyond the one change that was due if the first forecast was wrong."""
        changes = sum(one != two for one, two in zip(self.said, self.said[1:], strict=False))
        return max(0, changes - (self.said[0] != self.outcome))

    @property
    def locked(self) -> int:
        """At how many repetitions the forecast was wrong although the last two validations that were there told what holds."""
        return sum(
            said != self.outcome and known >= 2 and self.told[known - 2 : known] == (self.outcome, self.outcome)
            for said, known in zip(self.said, self.known, strict=True)
        )

    @property
    def wrong(self) -> int:
        """At how many repetitions after the first the forecast was wrong."""
        return sum(said != self.outcome for said in self.said[1:])


def courses(of: DriftWorld, said: Sequence[Said]) -> tuple[Course, ...]:
    """What was said of each changed signature."""
    found: list[Course] = []
    for name in dict.fromkeys(met.signature for met in of.stream if met.signature):
        places = [place for place, met in enumerate(of.stream) if met.signature == name]
        outcome = of.stream[places[0]].outcome
        found.append(
            Course(
                signature=name,
                outcome=outcome,
                said=tuple(said[place].outcome for place in places),
                told=tuple(of.stream[place].told for place in places),
                known=tuple(sum(of.stream[each].known_from <= place for each in places) for place in places),
                trust=tuple(_trust(said[place], outcome) for place in places),
            )
        )
    return tuple(found)


def _trust(said: Said, outcome: int) -> float | None:
    if said.trust is None:
        return None
    return said.trust if said.outcome == outcome else 1.0 - said.trust


def newest_wins(course: Course) -> Course:
    """The same signature, had one always forecast what was told last."""
    return _as_if(course, lambda _, told: told[-1])


def two_confirmations(course: Course) -> Course:
    """The same, had one changed the forecast only after the same had been told twice in a row."""
    return _as_if(course, lambda before, told: told[-1] if len(told) > 1 and told[-1] == told[-2] else before)


def _as_if(course: Course, rule: Callable[[int, tuple[int, ...]], int]) -> Course:
    said = [course.said[0]]
    for known in course.known[1:]:
        said.append(rule(said[-1], course.told[:known]) if known else said[-1])
    return Course(
        signature=course.signature,
        outcome=course.outcome,
        said=tuple(said),
        told=course.told,
        known=course.known,
        trust=(None,) * len(said),
    )


def told_of(found: Sequence[Course]) -> list[str]:
    """Sentences on swings, locks and errors, beside two simple rules on the very same validations."""
    rules = {
        "wakeful": list(found),
        "newest wins": [newest_wins(each) for each in found],
        "two confirmations": [two_confirmations(each) for each in found],
    }
    parts = [
        f"{name} {fmean(each.swings for each in of):.2f} swings, {fmean(each.locked for each in of):.2f} repetitions locked in "
        f"an error, {fmean(each.wrong for each in of):.2f} of 5 forecasts wrong after the first"
        for name, of in rules.items()
    ]
    return [f"Trust under noisy, per changed signature: {'; '.join(parts)}."]

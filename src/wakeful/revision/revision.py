"""Revision: trust per treatment; a contradiction lowers it, and what rests on the same knowledge is thought about again."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec

from wakeful.facts.domain import DomainSpec
from wakeful.facts.experience import Experience, ModelCard, Verdict
from wakeful.facts.lines import (
    AnyRecord,
    Concluded,
    Created,
    Decided,
    Drifted,
    Gained,
    Judged,
    Moved,
    Published,
    Reopened,
    Trusted,
)
from wakeful.facts.packs import Covered, Ran
from wakeful.facts.processes import State
from wakeful.revision.drift import Drift
from wakeful.revision.reliability import Reliability
from wakeful.revision.standing import Made, Stale, Standing
from wakeful.revision.track import Track

_DIGITS = 6


class RevisionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How trust moves.

    ``initial``: the share of results that is expected to be supported of a treatment that nothing is known of, weighing
    ``initial_cases`` outcomes; ``record_memory``: outcomes over which that share forgets. ``limit``: what automatic execution
    needs. ``gain``: the part of what a contradiction took that a support makes good. ``drop``: the part of trust that the
    contradiction of an automatic result takes at once where outcomes are wholly reliable. ``probation``: trust once a new model
    version has learned from the contradiction, where the record supports as much. ``memory``: outcomes over which reliability
    forgets; ``prior_agreed`` and ``prior_differed``: what it starts from. ``doubted``: experiences whose trust is remembered;
    ``keep``: settled decisions.
    """

    initial: float = 0.8
    initial_cases: float = 4.0
    record_memory: float = 50.0
    limit: float = 0.4
    gain: float = 0.25
    drop: float = 0.7
    probation: float = 0.6
    memory: float = 100.0
    prior_agreed: float = 4.0
    prior_differed: float = 1.0
    doubted: int = 5_000
    keep: int = 10_000


class Revision:
    """Trust and reopening. Pure: no clock; state changes only in ``apply``.

    What the kernel does with it: ``apply`` of every record; after ``apply(Gained)``, ``weigh(experience)`` and, each of its
    Trusted recorded, ``drifted(treatment)`` and ``reopen(experience, limit)``; before it records a Published,
    ``relearned(card)``.

    Trust is a treatment's record times its standing. The record is the expected share of its results that the world supports, in
    whatever mode, recent ones counting more (`Track`): a treatment that is contradicted as often as not is trusted by half. The
    standing is 1 until an automatic result is contradicted, which takes a part of it at once, as much as outcomes have proved
    reliable (`Reliability`); support in any mode, and a model version that has learned from it, give it back.
    """

    def __init__(self, spec: DomainSpec, settings: RevisionSettings | None = None) -> None:
        self.settings = settings or RevisionSettings()
        self._treatments = spec.treatments
        self._trust: dict[str, float] = {}
        self._track = Track(self.settings.initial, self.settings.initial_cases, self.settings.record_memory)
        self._contradicted: dict[str, int] = {}
        self._doubts: dict[int, tuple[float, int]] = {}
        self._criticality: dict[int, int] = {}
        self._reliability = Reliability(self.settings.memory, self.settings.prior_agreed, self.settings.prior_differed)
        self._standing = Standing(self.settings.keep)
        self._drift = Drift()

    def trust(self, treatment: str) -> float:
        """Trust in automatic execution of a treatment, in [0, 1]."""
        return self._trust.get(treatment, self.settings.initial)

    def allows(self, treatment: str) -> bool:
        """Whether trust is enough for automatic execution."""
        return self.trust(treatment) >= self.settings.limit

    def levels(self, rests_on: Sequence[int] = ()) -> dict[str, float]:
        """Trust per treatment, as selection takes it.

        Args:
            rests_on: the experiences that the decision at hand would rest on. Where one of them was contradicted and no model
                version has learned from that yet, trust in every treatment is lowered by the same share: knowledge is
                doubted for what it said, whichever treatment would use it.

        Returns:
            One level for each treatment that anything is known of, and each that the domain names; all others are at
            ``settings.initial`` times the doubt.
        """
        doubt = self.doubt(rests_on)
        names = {*self._treatments, *self._trust}
        return {name: round(self.trust(name) * doubt, _DIGITS) for name in sorted(names)}

    def doubt(self, rests_on: Sequence[int]) -> float:
        """Trust in the least trusted of these experiences, in [0, 1]; 1 where none of them was contradicted."""
        return min((self._doubts[id_][0] for id_ in rests_on if id_ in self._doubts), default=1.0)

    @property
    def reliability(self) -> float:
        """How reliable outcomes have proved, in [0, 1]: what one contradiction counts for."""
        return round(self._reliability.weight, _DIGITS)

    def weigh(self, experience: Experience) -> list[Trusted]:
        """The change of trust that an experience brings, none where there is none. It was applied (Gained) just before."""
        treatment = experience.treatment
        share, standing = self._track.share(treatment), self._track.standing(treatment)
        if experience.verdict is Verdict.SUPPORTED:
            level = share * (standing + self.settings.gain * min(1.0, experience.weight) * (1.0 - standing))
            if round(min(1.0, max(0.0, level)), _DIGITS) == self._trust.get(treatment, self.settings.initial):
                return []
        said = f"{share:.0%} of its recent results were supported"
        if experience.verdict is Verdict.SUPPORTED:
            standing += self.settings.gain * min(1.0, experience.weight) * (1.0 - standing)
            why = f"{_mode(experience)} result was supported: {experience.outcome!r} came; {said}"
        elif experience.verdict is Verdict.CONTRADICTED:
            automatic = experience.mode == "auto"
            if automatic:
                standing *= 1.0 - self.settings.drop * min(1.0, self.reliability * experience.weight)
            why = (
                f"{_mode(experience)} result was contradicted: it forecast {experience.predicted!r}, "
                f"{experience.outcome!r} came; {said}"
                + (f"; outcomes have proved {self.reliability:.0%} reliable" if automatic else "")
            )
        else:
            return []
        return self._trusted(treatment, share * standing, why, experience.id)

    def drifted(self, treatment: str) -> list[Drifted]:
        """The alarm that a treatment errs more than it did, if there is one. Its experience was applied (Gained) just before."""
        alarm = self._drift.alarm(treatment)
        if alarm is None:
            return []
        return [
            Drifted(
                treatment=treatment,
                before=alarm.before,
                wrong=alarm.wrong,
                of=alarm.of,
                changed=alarm.changed,
                why=alarm.says,
            )
        ]

    def relearned(self, card: ModelCard) -> list[Trusted]:
        """Trust given back on probation: an accepted version has learned from the contradictions that lowered it."""
        if not card.accepted:
            return []
        return [
            trusted
            for treatment, experience in sorted(self._contradicted.items())
            if experience <= card.watermark
            for trusted in self._on_probation(treatment, experience, card.version)
        ]

    def reopen(self, experience: Experience, limit: int) -> list[Stale]:
        """The automatic decisions to be thought about again after a contradiction, the most critical first.

        They forecast what was refuted, rest on at least half of the same experiences, and the world has not shown yet how
        they end. None where the contradicted result was not automatic, or where outcomes have proved unreliable.

        Args:
            experience: just gained.
            limit: at most so many; fewer in proportion to how reliable outcomes have proved.
        """
        if experience.verdict is not Verdict.CONTRADICTED or experience.mode != "auto":
            return []
        made = self._standing.get(experience.process)
        if made is None:
            return []
        count = round(limit * self.reliability)
        return [
            Stale(
                process=other.process,
                event=other.event,
                treatment=other.treatment,
                because=(
                    f"it rests on {_listed(shared)}, as did a decision for {experience.predicted!r} that "
                    f"experience {experience.id} contradicted with {experience.outcome!r}"
                ),
            )
            for other, shared in self._standing.sharing(made)[:count]
        ]

    def apply(self, record: AnyRecord, now_ns: int) -> None:
        """Take up one record of the journal, live and in recovery alike. Records that concern other rooms are passed over."""
        self._standing.let_close(now_ns)
        match record:
            case Created(process=process, criticality=criticality):
                self._criticality[process] = criticality
            case Decided(process=process, event=event, decision=decision):
                made = Made(
                    process=process,
                    event=event,
                    treatment=decision.treatment,
                    mode=decision.mode,
                    rests_on=decision.rests_on,
                    criticality=self._criticality.get(process, 0),
                )
                self._standing.decide(made)
            case Concluded(process=process, mode=mode, forecast=forecast, closes_ns=closes_ns):
                self._standing.conclude(process, mode, forecast.label if forecast is not None else "", closes_ns)
            case Moved(process=process, after=State.COMPLETED):
                self._criticality.pop(process, None)
                self._standing.drop(process)
            case Judged(process=process):
                self._standing.settle(process)
            case Reopened(reopens=reopens):
                self._standing.settle(reopens)
            case Gained(experience=experience):
                self._gain(experience)
            case Drifted(treatment=treatment):
                self._drift.reset(treatment)
            case Trusted(treatment=treatment, after=after):
                self._trust[treatment] = after
                self._track.stand(treatment, after)
            case Published(card=card) if card.accepted:
                self._doubts = {id_: doubt for id_, doubt in self._doubts.items() if doubt[1] > card.watermark}
                self._contradicted = {name: id_ for name, id_ in self._contradicted.items() if id_ > card.watermark}

    def level(self, treatment: str, rests_on: Sequence[int]) -> float:
        """``levels(rests_on)`` of one treatment; 1 where it is not named there."""
        if treatment not in self._trust and treatment not in self._treatments:
            return 1.0
        doubt = self.doubt(rests_on) if self._doubts else 1.0
        return round(self.trust(treatment) * doubt, _DIGITS)

    def covered(self, burst: Covered) -> None:
        """Take up an automatic decision: what ``apply`` does with its lines."""
        choice, event = burst.choice, burst.event
        self._standing.cover(
            Made(
                process=burst.process,
                event=event.id,
                treatment=choice.basis.treatment,
                mode="auto",
                rests_on=choice.rests_on,
                criticality=event.criticality,
            )
        )

    def park(self, process: int) -> Made | None:
        """Give away the decision of a process that is put out of memory while it waits; None where it is still needed."""
        return self._standing.park(process)

    def bring_back(self, made: Made) -> None:
        """Take a parked process's decision back."""
        self._standing.cover(made)

    def ran(self, burst: Ran, label: str) -> None:
        """Take up a result, with the label that it forecast: what ``apply`` does with its lines."""
        self._standing.conclude(burst.process, burst.mode, label, burst.closes_ns)

    def validated(self, experience: Experience, now_ns: int) -> None:
        """Take up a verdict's experience: what ``apply`` does with the lines but for that of trust."""
        self._standing.let_close(now_ns)
        self._standing.settle(experience.process)
        self._gain(experience)

    def _on_probation(self, treatment: str, experience: int, version: int) -> list[Trusted]:
        after = min(self.settings.probation, self._track.share(treatment))
        if self.trust(treatment) >= after:
            return []
        why = f"model version {version} has learned from the contradiction: trusted again on probation"
        return self._trusted(treatment, after, why, experience)

    def _trusted(self, treatment: str, level: float, why: str, experience: int) -> list[Trusted]:
        before, after = self.trust(treatment), round(min(1.0, max(0.0, level)), _DIGITS)
        if after == before:
            return []
        return [Trusted(treatment=treatment, before=before, after=after, why=why, experience=experience)]

    def _gain(self, experience: Experience) -> None:
        self._track.learn(experience)
        self._drift.learn(experience)
        made = self._standing.get(experience.process)
        rests_on = made.rests_on if made is not None else ()
        self._reliability.learn(experience, rests_on)
        if experience.verdict is Verdict.SUPPORTED:
            for id_ in rests_on:
                if id_ in self._doubts:
                    trust, contradicted_by = self._doubts[id_]
                    self._doubts[id_] = (trust + self.settings.gain * (1.0 - trust), contradicted_by)
        elif experience.verdict is Verdict.CONTRADICTED and experience.mode == "auto":
            self._contradicted[experience.treatment] = experience.id
            kept = 1.0 - self.settings.drop * min(1.0, self.reliability * experience.weight)
            for id_ in rests_on:
                trust, _ = self._doubts.pop(id_, (1.0, 0))
                self._doubts[id_] = (trust * kept, experience.id)
            while len(self._doubts) > self.settings.doubted:
                del self._doubts[next(iter(self._doubts))]


def _mode(experience: Experience) -> str:
    return {"auto": "an automatic", "delib": "a deliberated", "fallback": "a provisional"}.get(
        experience.mode, f"a {experience.mode}"
    )


def _listed(experiences: tuple[int, ...]) -> str:
    numbers = ", ".join(str(id_) for id_ in experiences)
    return f"experience {numbers}" if len(experiences) == 1 else f"experiences {numbers}"

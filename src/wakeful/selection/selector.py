"""S(e, c, H) of Eq. 4: what treatment an event gets, and separately how it is executed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Final

import msgspec

from wakeful.contracts.learner import Estimate, Learner, Predictor, RowPredictor
from wakeful.facts.choices import Basis, Choice, said
from wakeful.facts.decisions import Candidate, Decision, Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Draft, Event
from wakeful.facts.experience import ModelCard
from wakeful.selection.batch import BatchEncoder
from wakeful.selection.features import Encoder, Vector
from wakeful.selection.foresight import Foresight, Seen, alone, of_one
from wakeful.selection.gating import GATE_DIGITS, RESULT, Gating, SelectionSettings
from wakeful.selection.guarantee import Guarantee
from wakeful.selection.guidelines import Advice, advise, expected

GENERAL_TREATMENTS: Final = ("analogy", "description")
"""What an unfamiliar event gets where no guideline speaks for anything: a general treatment (Section III of the paper)."""


class Selector:
    """Decides for one event at a time, from its features, trust, and the model version in use; it never sees the truth.

    Args:
        spec: the domain; its guidelines are what a mind without experience starts from.
        treatments: all registered treatments, in a fixed order; ``spec.treatments`` may allow fewer.
        learner: loads the weights that ``use`` is given.
        settings: the gate.
        guarantee: the guarantee gate, which then takes the place of the thresholds of confidence; None for the others.

    Raises:
        ValueError: the domain allows none of the registered treatments.
    """

    def __init__(
        self,
        spec: DomainSpec,
        treatments: tuple[str, ...],
        learner: Learner,
        settings: SelectionSettings,
        guarantee: Guarantee | None = None,
    ) -> None:
        self.spec = spec
        self._gating = Gating(settings, guarantee)
        self.encoder = Encoder(spec, treatments)
        self.allowed = tuple(name for name in treatments if not spec.treatments or name in spec.treatments)
        if not self.allowed:
            raise ValueError(
                f"domain {spec.name!r} allows {', '.join(spec.treatments)}, but registered are only "
                f"{', '.join(treatments) or 'none'}; register one of them or change the domain's treatments"
            )
        self._learner = learner
        self._card: ModelCard | None = None
        self._predictor: Predictor | None = None
        self._places: tuple[int | None, ...] = ()
        self._last: tuple[Event, Vector] | None = None
        self._batches = BatchEncoder(self.encoder)
        self._foresight: Foresight | None = None

    @property
    def card(self) -> ModelCard | None:
        """The model version in use; None while guidelines decide."""
        return self._card

    @property
    def predictor(self) -> Predictor | None:
        """The loaded model version in use."""
        return self._predictor

    def encode(self, event: Event) -> Vector:
        """The event's features, shape (d,). The last event's are remembered: read them, don't write to them."""
        if self._last is None or self._last[0] is not event:
            features = self.encoder.encode(event)
            features.flags.writeable = False
            self._last = (event, features)
        return self._last[1]

    def encode_many(self, events: Sequence[Event]) -> Vector:
        """The features of many events, shape (n, d)."""
        return self._batches.encode(events)

    def use(self, card: ModelCard, weights: bytes) -> None:
        """Decide with this model version from now on (an older one rolls back).

        Raises:
            ValueError: the bytes are no model, or one of other features or labels than this domain's; the version in use stays.
        """
        predictor = self._learner.load(weights)
        if predictor.typical.shape != (self.encoder.size,):
            raise ValueError(
                f"model version {card.version} was fitted on {predictor.typical.size} features, "
                f"domain {self.spec.name!r} now has {self.encoder.size}; it must be trained again"
            )
        gone = sorted(set(predictor.labels) - set(self.spec.outcome.labels))
        if gone:
            raise ValueError(
                f"model version {card.version} forecasts {', '.join(gone)}, which is no outcome of domain {self.spec.name!r} "
                "any more; it must be trained again"
            )
        place = {name: index for index, name in enumerate(predictor.treatments)}
        self._places = tuple(place.get(name) for name in self.allowed)
        self._card, self._predictor = card, predictor
        self._foresight = Foresight(
            [self._basis(card, predictor, name) for name in self.allowed], self._places, self._gating.settings.support
        )

    def _basis(self, card: ModelCard, predictor: Predictor, treatment: str) -> Basis:
        return Basis(
            treatment=treatment,
            model=card.version,
            watermark=card.watermark,
            treatments=self.allowed,
            labels=predictor.labels,
            threshold=round(self._gating.threshold(card, treatment), GATE_DIGITS),
            result_threshold=self._gating.threshold(card, RESULT),
            novelty_limit=self._gating.settings.novelty_limit,
            trust_limit=self._gating.settings.trust_limit,
            support=card.support.get(treatment, 0),
        )

    def foresee(self, events: Sequence[Event | Draft]) -> list[Seen] | None:
        """What the model version in use says of these events, all at once; None where no model, or none for batches, is in use.

        It stands as long as that version is in use, whatever else comes between.
        """
        if self._foresight is None or not isinstance(self._predictor, RowPredictor):
            return None
        return self._foresight.see(self._predictor.estimate_rows(self._batches.encode(events)))

    def see(self, event: Event) -> Seen | None:
        """The same of one event; None where no model is in use."""
        if self._foresight is None or self._predictor is None:
            return None
        return self._foresight.see(alone(self._predictor.estimate(self.encode(event))))[0]

    def forecast(self, seen: Seen) -> dict[str, float]:
        """What the model version in use alone forecasts of the event; empty where none is in use."""
        if self._predictor is None:
            return {}
        return dict(zip(self._predictor.labels, of_one(seen).labels.tolist(), strict=True))

    def joined(self, seen: Seen, labels: Vector) -> Seen:
        """The same with another forecast, over the model version's labels, shape (l,), in place of the model's own."""
        if self._foresight is None:
            return seen
        return self._foresight.see(alone(msgspec.structs.replace(of_one(seen), labels=labels)))[0]

    def cells(self, events: Sequence[Event]) -> list[int]:
        """The cells of the model's experience in which these events lie; -1 for all where it has none, or no model is in use."""
        if not isinstance(self._predictor, RowPredictor) or not events:
            return [-1] * len(events)
        found: list[int] = self._predictor.estimate_rows(self._batches.encode(events)).cells.tolist()
        return found

    def choose(self, seen: Seen, trust: float, rests_on: tuple[int, ...]) -> Choice | None:
        """The automatic decision on an event, if it may be decided so; else it is for ``decide``.

        Args:
            seen: what the model version in use says of the event.
            trust: revision's trust in ``seen``'s treatment.
            rests_on: ids of the nearest experiences.
        """
        if self._foresight is None or self._gating.guarantee is not None:
            return None
        return self._foresight.choose(seen, trust, rests_on)

    def decide(
        self,
        event: Event,
        trust: Mapping[str, float],
        nearest: tuple[int, ...],
        watermark: int,
        seen: Seen | None = None,
    ) -> Decision:
        """What treatment the event gets, and how.

        Args:
            event: the admitted event; ``truth_treatment`` is not looked at.
            trust: revision's trust per treatment in [0, 1]; one that is not named is fully trusted.
            nearest: ids of the nearest experiences, recorded as what the decision rests on.
            watermark: how many experiences the model version in use had learned from.
            seen: what the model version in use says of the event, where that is known already.

        Returns:
            A decision that depends on nothing but these arguments and the version in use. Every number is rounded before it is
            compared (probabilities to 9 digits, the gate's to 6), so that batching changes nothing.
        """
        if seen is None:
            seen = self.see(event)
        if seen is None or self._predictor is None or self._card is None:
            return self._by_guidelines(event, trust, nearest, watermark)
        choice = self.choose(seen, trust.get(seen[0].treatment, 1.0), nearest)
        if choice is not None:
            return msgspec.structs.replace(choice.decision(), watermark=watermark)
        return self._by_model(event, trust, nearest, watermark, self._card, self._predictor, of_one(seen))

    def _by_guidelines(self, event: Event, trust: Mapping[str, float], nearest: tuple[int, ...], watermark: int) -> Decision:
        advice = advise(self.spec, self.allowed, event)
        chosen, reasons = self._advised(advice)
        ranked = _ranked(self.allowed, advice.shares, first=chosen)
        mode: Mode = "fallback" if advice.leading is None else "delib"
        reasons.append(
            "Nothing has been learned yet, so this is "
            + ("a general treatment for the time being." if mode == "fallback" else "deliberated, not automatic.")
        )
        return Decision(
            treatment=chosen,
            mode=mode,
            confidence=round(ranked[0].probability, GATE_DIGITS),
            candidates=ranked,
            reasons=tuple(reasons),
            gate=self._gating.gate(ranked[0].probability, self._gating.settings.confidence, 1.0, trust.get(chosen, 1.0)),
            prior=expected(self.spec, advice.leading),
            watermark=watermark,
            rests_on=nearest,
        )

    def _by_model(
        self,
        event: Event,
        trust: Mapping[str, float],
        nearest: tuple[int, ...],
        watermark: int,
        card: ModelCard,
        predictor: Predictor,
        estimate: Estimate,
    ) -> Decision:
        known = estimate.treatments.tolist()
        raw = [0.0 if place is None else known[place] for place in self._places]
        total = sum(raw)
        shares = tuple(round(value / total, 9) for value in raw) if total > 0.0 else tuple(0.0 for _ in raw)
        novelty = round(estimate.novelty, GATE_DIGITS)
        prior = dict(zip(predictor.labels, estimate.labels.tolist(), strict=True))
        if novelty > self._gating.settings.novelty_limit or total <= 0.0:
            advice = advise(self.spec, self.allowed, event)
            chosen, reasons = self._advised(advice)
            if advice.leading is not None:
                shares = advice.shares
                if advice.leading.expect:
                    prior = expected(self.spec, advice.leading)
            ranked = _ranked(self.allowed, shares, first=chosen)
        else:
            ranked = _ranked(self.allowed, shares)
            chosen = ranked[0].treatment
            reasons = [said(ranked, card.version, card.watermark)]
        gate = self._gating.gate(ranked[0].probability, self._gating.threshold(card, chosen), novelty, trust.get(chosen, 1.0))
        mode, why, audit = self._gating.mode(event.id, chosen, gate, prior, card)
        return Decision(
            treatment=chosen,
            mode=mode,
            confidence=gate.confidence,
            candidates=ranked,
            reasons=(*reasons, *why),
            gate=gate,
            prior=prior,
            model=card.version,
            watermark=watermark,
            rests_on=nearest,
            audit=audit,
        )

    def _advised(self, advice: Advice) -> tuple[str, list[str]]:
        if advice.leading is not None:
            return advice.leading.treat, [f"Guideline: {advice.leading.because}"] + [
                f"Also: {line.because}" for line in advice.also if line.treat != advice.leading.treat
            ]
        general = next((name for name in GENERAL_TREATMENTS if name in self.allowed), self.allowed[0])
        return general, [f"No guideline of domain {self.spec.name} holds for this event."]


def _ranked(names: tuple[str, ...], shares: tuple[float, ...], first: str = "") -> tuple[Candidate, ...]:
    """By probability rounded to 6 digits, then by the treatments' own order; ``first`` leads whatever its share."""
    order = sorted(range(len(names)), key=lambda i: (names[i] != first, -round(shares[i], GATE_DIGITS), i))
    return tuple(Candidate(treatment=names[i], probability=shares[i]) for i in order)

"""How a treatment is executed (z of Eq. 4), apart from which: what is unfamiliar, untrusted or in doubt is not automatic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, Literal

import msgspec

from wakeful.facts.choices import automatic, guaranteed, likeliest
from wakeful.facts.decisions import Audit, Gate, Mode
from wakeful.facts.experience import ModelCard
from wakeful.facts.settings import MindSettings
from wakeful.selection.guarantee import Guarantee

POOLED: Final = "*"
"""The key of ``ModelCard.thresholds`` for treatments without a threshold of their own."""
RESULT: Final = "@result"
"""The key of ``ModelCard.thresholds`` for the result head's confidence."""

GATE_DIGITS: Final = 6
"""What a gate compares is rounded to so many digits first."""


class SelectionSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When a treatment may be executed automatically.

    ``confidence`` and ``result_confidence`` are what the two heads need where the model version carries no threshold that was
    chosen on held-back experience, or always with ``thresholds="fixed"``. ``novelty_limit`` is a quantile of the distances of
    what is familiar, ``trust_limit`` what revision's trust must reach, ``support`` how many validated experiences a treatment
    needs.
    """

    thresholds: Literal["chosen", "fixed"] = "chosen"
    confidence: float = 0.90
    result_confidence: float = 0.55
    novelty_limit: float = 0.99
    trust_limit: float = 0.4
    support: int = 1

    @classmethod
    def under(cls, settings: MindSettings) -> SelectionSettings:
        """The defaults, with the mind's own rate of false alarms of novelty.

        Raises:
            ValueError: the rate is none.
        """
        if not 0.0 <= settings.novelty_rate < 1.0:
            raise ValueError(f"novelty_rate is {settings.novelty_rate}; it is a share of the familiar events, from 0 to below 1")
        return cls(novelty_limit=round(1.0 - settings.novelty_rate, GATE_DIGITS))


class Gating:
    """The gate of a selector: thresholds of confidence, or the guarantee in their place.

    Args:
        settings: what a treatment needs.
        guarantee: the guarantee gate; None for thresholds.
    """

    def __init__(self, settings: SelectionSettings, guarantee: Guarantee | None) -> None:
        self.settings = settings
        self.guarantee = guarantee

    def threshold(self, card: ModelCard, key: str) -> float:
        """What the confidence in a treatment, or under ``RESULT`` in the forecast, has to reach with this model version."""
        default = self.settings.result_confidence if key == RESULT else self.settings.confidence
        if self.settings.thresholds == "fixed":
            return default
        found = card.thresholds.get(key)
        if found is None and key != RESULT:
            found = card.thresholds.get(POOLED)
        return default if found is None else found

    def gate(self, confidence: float, threshold: float, novelty: float, trust: float) -> Gate:
        """The numbers that are compared, as they are recorded."""
        return Gate(
            confidence=round(confidence, GATE_DIGITS),
            threshold=round(threshold, GATE_DIGITS),
            novelty=round(novelty, GATE_DIGITS),
            novelty_limit=self.settings.novelty_limit,
            trust=round(trust, GATE_DIGITS),
            trust_limit=self.settings.trust_limit,
        )

    def mode(
        self, event: str, chosen: str, gate: Gate, prior: Mapping[str, float], card: ModelCard
    ) -> tuple[Mode, list[str], Audit | None]:
        """How the chosen treatment is executed, why, and under the guarantee what it ruled of the event.

        Args:
            event: its id, by which it is drawn for an audit.
            chosen: the treatment.
            gate: the numbers.
            prior: the forecast.
            card: the model version in use.
        """
        if gate.novelty > gate.novelty_limit:
            unlike = (
                f"Unlike anything experienced so far: novelty {gate.novelty:.3f} is above {gate.novelty_limit:g}, "
                "so the treatment is provisional."
            )
            return "fallback", [unlike], None
        doubts = self._unfit(chosen, gate, card)
        if self.guarantee is not None:
            return self._guaranteed(self.guarantee, event, chosen, gate, prior, card, doubts)
        if gate.confidence < gate.threshold:
            doubts.append(_below("The confidence in the treatment", gate.confidence, gate.threshold))
        label, confidence = likeliest(prior)
        needed = self.threshold(card, RESULT)
        if confidence < needed:
            doubts.append(_below(f"The forecast {label!r}", confidence, needed))
        if doubts:
            return "delib", doubts, None
        return "auto", [automatic(gate, prior, needed, card.support.get(chosen, 0))], None

    @staticmethod
    def _guaranteed(
        guarantee: Guarantee,
        event: str,
        chosen: str,
        gate: Gate,
        prior: Mapping[str, float],
        card: ModelCard,
        doubts: list[str],
    ) -> tuple[Mode, list[str], Audit | None]:
        """Under the guarantee: what is untrusted or unheard of is no candidate, the rest is up to it."""
        if doubts:
            return "delib", doubts, None
        label, confidence = likeliest(prior)
        audit = guarantee.rule(event, chosen, label, card.version, gate.confidence * confidence)
        deliberated = audit.drawn and guarantee.settings.audit_by == "deliberation"
        return ("auto" if audit.automatic and not deliberated else "delib"), [guaranteed(audit, deliberated)], audit

    def _unfit(self, chosen: str, gate: Gate, card: ModelCard) -> list[str]:
        """What keeps a familiar event from being automatic, whatever the confidence; empty where nothing does."""
        doubts: list[str] = []
        support = card.support.get(chosen, 0)
        if support < self.settings.support:
            doubts.append(
                f"{chosen} has {support} validated experiences, automatic execution needs {self.settings.support}."
                if support
                else f"No experience of {chosen} has been validated yet."
            )
        if gate.trust < gate.trust_limit:
            doubts.append(f"Trust in {chosen} is {gate.trust:.2f} after contradictions, below {gate.trust_limit:g}.")
        return doubts


def _below(what: str, number: float, needed: float) -> str:
    if needed > 1.0:
        return f"{what} ({number:.3f}) does not count yet: on held-back experience even the most confident went wrong too often."
    return f"{what} ({number:.3f}) is below {needed:.2f}."

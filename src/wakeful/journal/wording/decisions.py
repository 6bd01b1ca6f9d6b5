"""A decision in words: how it was executed, the model version, the gate's numbers, what was remembered."""

from __future__ import annotations

from wakeful.facts.decisions import Audit, Decision, Gate, Mode
from wakeful.journal.history import History
from wakeful.journal.story import Remembered
from wakeful.journal.wording.words import count

MODES: dict[Mode, str] = {"auto": "automatically", "delib": "with deliberation", "fallback": "in fallback (provisional)"}
_VERSIONS = 5
"""A longer lineage is told by its ends."""


def model_words(read: History, decision: Decision) -> str:
    """The model version that decided, with what it came from."""
    if not decision.model:
        return "no model yet, chosen by the domain's guidelines"
    cards = {record.card.version: record.card for _, record in read.published}
    line: list[str] = []
    version = decision.model
    while version in cards and str(version) not in line:
        line.append(str(version))
        version = cards[version].base
    if len(line) > _VERSIONS:
        line = [*line[:2], "…", line[-1]]
    trained = f", learned from {count(decision.watermark, 'experience')}" if decision.watermark else ""
    return f"model version {' ← '.join(line) if line else decision.model}{trained}"


def gate_lines(gate: Gate, audit: Audit | None = None) -> list[tuple[str, bool]]:
    """The numbers that were compared, in words, each with whether it allowed automation.

    Args:
        gate: what was compared under every gate.
        audit: what the guarantee gate did, where that was the gate: its level then stands in place of the threshold.
    """
    return [
        _certified(audit)
        if audit is not None
        else (
            f"confidence {gate.confidence:.3f} reaches the threshold {gate.threshold:.3f}"
            if gate.threshold <= 1.0
            else f"confidence {gate.confidence:.3f} counts: held-back experience has shown that it can be relied on",
            gate.confidence >= gate.threshold,
        ),
        (f"novelty {gate.novelty:.3f} stays within {gate.novelty_limit:.3f}", gate.novelty <= gate.novelty_limit),
        (f"trust {gate.trust:.3f} reaches {gate.trust_limit:.3f}", gate.trust >= gate.trust_limit),
    ]


def _certified(audit: Audit) -> tuple[str, bool]:
    risk = f"a risk of {100 * audit.alpha:g} %"
    if audit.level > 1.0:
        return f"the treatment is certified at {risk}: not yet, so every outcome counts as evidence", False
    how = "every outcome counts" if audit.probability >= 1.0 else f"outcomes count one in {1 / audit.probability:.3g}"
    draw = f"{how}, this one {'does' if audit.drawn else 'does not'}"
    return f"score {audit.score:.3f} reaches {audit.level:.2f}, from which {risk} is certified ({draw})", audit.automatic


def memory_words(memory: Remembered) -> str:
    """A remembered experience: what its event was, what was forecast, and what the world showed."""
    experience = memory.experience
    about = memory.says or f"{memory.kind} of {memory.entity}"
    return (
        f"{experience.id}: {about} [{experience.event[:10]}]: {experience.treatment} forecast "
        f"{experience.predicted or 'nothing'}, the world showed {experience.outcome}: {experience.verdict}"
    )

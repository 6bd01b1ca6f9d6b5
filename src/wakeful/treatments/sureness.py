"""How sure a treatment may be, and how it says so: fallback is provisional, and nothing to go on is said, not hidden."""

from __future__ import annotations

from wakeful.contracts.treatment import Mind

#: What is left of the confidence of a treatment that nobody has yet found fit for the event.
FALLBACK_SHARE = 0.5

#: The confidence of a treatment that had nothing to go on.
NOTHING_TO_GO_ON = 0.1


def sure(mind: Mind, confidence: float) -> float:
    """The confidence to state: in [0, 1], lower in fallback mode, rounded."""
    share = FALLBACK_SHARE if mind.mode == "fallback" else 1.0
    return round(min(max(confidence * share, 0.0), 1.0), 4)


def sentence(mind: Mind, about: str, *parts: str) -> str:
    """What it is about, a colon, and the parts as one sentence, marked as provisional in fallback mode."""
    said = "".join(part for part in parts if part).strip().lstrip(":; ")
    said = f"{about}: {said}" if said else about
    marked = f"Provisional: {said}" if mind.mode == "fallback" else said
    return marked if marked.endswith(("?", ".", "!")) else marked + "."

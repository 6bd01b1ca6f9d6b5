"""What the guarantee gate would have allowed in Experiment 1, from its calibration set alone: one look at a set of fixed size."""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from wakeful.experiments.exp1_methods import Choice
from wakeful.experiments.worlds.service_events import TREATMENTS, Case
from wakeful.selection.guarantee.bounds import error_free_needed
from wakeful.selection.guarantee.fixed import level_for

ALPHA = 0.05
DELTA = 0.05


def levels(told: Sequence[Choice], cases: Sequence[Case]) -> dict[str, float]:
    """For each treatment the confidence from which P(wrong and automatic) is held under ``ALPHA`` with probability 1 − ``DELTA``.

    Args:
        told: what was chosen for events that the chooser had not learned from.
        cases: these events.
    """
    found = {}
    for name in TREATMENTS:
        own = [(choice, case) for choice, case in zip(told, cases, strict=True) if choice.learned == name]
        scores = np.array([choice.confidence or 0.0 for choice, _ in own])
        wrong = np.array([choice.learned != case.truth for choice, case in own], dtype=np.bool_)
        found[name] = level_for(scores, wrong, ALPHA, DELTA)
    return found


def guaranteed(choices: Sequence[Choice], allowed_from: dict[str, float]) -> list[Choice]:
    """The choices, each with whether the guarantee gate would have let it be automatic."""

    def passes(choice: Choice) -> bool:
        return (choice.confidence or 0.0) >= allowed_from[choice.learned]

    return [msgspec.structs.replace(choice, guaranteed=passes(choice)) for choice in choices]


def said_of(shares: dict[str, float]) -> str:
    """One line: the share that the guarantee gate would have allowed, by method, in percent."""
    parts = ", ".join(f"{method} {share:.2f} %" for method, share in shares.items())
    return (
        f"The guarantee gate would have let be automatic, from the 42 calibration events alone: {parts} "
        f"(risk {ALPHA:.0%}, held with {1 - DELTA:.0%}; a treatment needs {error_free_needed(ALPHA, DELTA)} events of its own "
        "without an error)."
    )

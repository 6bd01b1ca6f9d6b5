"""Small worlds to learn: seeded, separable where they should be, and without any meaning of their own."""

from __future__ import annotations

import numpy as np

from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.time import Stamp

TREATMENTS = ("description", "diagnosis", "planning")
LABELS = ("none", "stop")


def job(
    rows: int = 120,
    seed: int = 0,
    training: int = 1,
    base: bytes = b"",
    base_version: int = 0,
    epochs: int = 40,
    held_back: float = 0.25,
    flip: bool = False,
    width: int = 6,
) -> TrainingJob:
    """Treatment by the greatest of the first three features, outcome by the fourth (the other way round with ``flip``)."""
    random = np.random.default_rng(seed)
    features = random.random((rows, width))
    treatment = features[:, :3].argmax(axis=1)
    result = (features[:, 3] > 0.5).astype(np.int64)
    return TrainingJob(
        training=training,
        base_version=base_version,
        base_weights=base,
        watermark=rows,
        seed=seed + training,
        epochs=epochs,
        treatments=TREATMENTS,
        labels=LABELS,
        features=features,
        treatment=treatment,
        result=1 - result if flip else result,
        refuted=np.full(rows, -1),
        weight=np.ones(rows),
        held_back=random.random(rows) < held_back,
    )


def event(number: int, kind: str = "k", load: float = 0.0, entity: str = "thing") -> Event:
    """An event that was received at ``number`` seconds."""
    return Event(
        id=f"e{number}",
        kind=kind,
        entity=entity,
        source="s",
        position=number,
        stamp=Stamp(source_ns=number * 10**9, received_ns=number * 10**9),
        fields={"load": load},
    )


def experience(
    number: int,
    of: Event,
    treatment: str = "description",
    label: str | None = None,
    predicted: str = "none",
    outcome: str = "none",
    mode: str = "delib",
    process: int = 0,
) -> Experience:
    """An experience with the verdict that its labels make, and the treatment label that validation would give it."""
    supported = predicted == outcome
    return Experience(
        id=number,
        event=of.id,
        process=process or number,
        treatment=treatment,
        treatment_label=label if label is not None else treatment if supported else "",
        predicted=predicted,
        outcome=outcome,
        verdict=Verdict.SUPPORTED if supported else Verdict.CONTRADICTED,
        mode=mode,
    )

"""What one event's selection costs, beside a floor: the bare numpy forward of the same shapes.

Run: `python benchmarks/selection.py`. Prints medians and the range from the 10th to the 90th percentile, in microseconds, of
single calls measured in turn, so that all rows see the same machine.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

from wakeful.contracts.learner import Vector
from wakeful.facts.domain import DetectorSpec, DomainSpec, FieldSpec, Guideline
from wakeful.facts.events import Context, Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Admitted, Gained
from wakeful.facts.time import Stamp
from wakeful.learning.episodes import Episodes
from wakeful.learning.plan import Learning, LearningSettings
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.explain import contributions
from wakeful.selection.gating import SelectionSettings
from wakeful.selection.selector import Selector

TREATMENTS = (
    "description", "memory", "risk_prediction", "planning", "diagnosis", "analogy", "comparison", "causal_analysis",
)  # fmt: skip
STATES = ("normal", "unstable", "abnormal")
SPEC = DomainSpec(
    name="bench",
    version=1,
    says="an arm of six joints",
    fields={
        "state": FieldSpec(values=STATES),
        "where": FieldSpec(values=("center", "edge", "route", "storage")),
        **{name: FieldSpec(low=0.0, high=10.0) for name in ("current", "speed", "temperature", "load", "slope", "duration")},
    },
    detect=tuple(DetectorSpec(detector="band", kind=kind) for kind in ("left_band", "trend", "unlike", "jump", "silent")),
    guideline=tuple(Guideline(treat=name, because=name, when={"load": f">{5 + at}"}) for at, name in enumerate(TREATMENTS)),
)
EVENTS, ROUNDS = 512, 20


def event(number: int, random: np.random.Generator) -> Event:
    """A seeded event with all declared fields and a little context."""
    return Event(
        id=f"{number:020x}",
        kind=SPEC.detect[int(random.integers(5))].kind,
        entity=f"joint_{int(random.integers(6))}",
        source="bench",
        position=number,
        stamp=Stamp(source_ns=number, received_ns=number),
        fields={
            "state": STATES[int(random.integers(3))],
            "where": "edge" if random.random() < 0.5 else "center",
            **{name: float(random.random() * 10) for name in ("current", "speed", "temperature", "load", "slope", "duration")},
        },
        context=Context(task=f"pick-{number}", zone="cell", fields={"cycle": number}),
    )


def bare(size: int) -> Callable[[Vector], Vector]:
    """The floor: three matrix products and two ReLUs of the same shapes, nothing else."""
    random = np.random.default_rng(0)
    first, second, heads = (
        random.normal(size=(size, 64)),
        random.normal(size=(64, 64)),
        random.normal(size=(64, len(TREATMENTS) + 2)),
    )

    def forward(x: Vector) -> Vector:
        return np.asarray(np.maximum(np.maximum(x @ first, 0.0) @ second, 0.0) @ heads)

    return forward


def main() -> None:
    """Measure and print the table."""
    random = np.random.default_rng(1)
    selector = Selector(SPEC, TREATMENTS, TwoHeads(), SelectionSettings())
    events = [event(number, random) for number in range(EVENTS)]
    learning = Learning(SPEC, TREATMENTS, TwoHeads(), selector.encode, LearningSettings())
    episodes = Episodes(selector.encode, limit=100_000)
    for number, one in enumerate(events, 1):
        load = one.fields["load"]
        treatment = TREATMENTS[int(float(load) / 10 * 4)] if isinstance(load, float) else TREATMENTS[0]
        outcome = "intervention" if one.fields["state"] == "abnormal" else "none"
        gained = Experience(
            id=number, event=one.id, process=number, treatment=treatment, treatment_label=treatment, predicted=outcome,
            outcome=outcome, verdict=Verdict.SUPPORTED, mode="delib",
        )  # fmt: skip
        learning.apply(Gained(experience=gained), one)
        episodes.apply(Admitted(event=one))
        episodes.apply(Gained(experience=gained))
    asked = learning.due(0)
    if asked is None:
        raise SystemExit("the benchmark's world gave no training")
    learning.apply(asked)
    begun = time.perf_counter()
    card, weights = learning.learner.train(learning.job(asked, b""))
    trained_s = time.perf_counter() - begun
    plain = Selector(SPEC, TREATMENTS, TwoHeads(), SelectionSettings())
    selector.use(card, weights)
    predictor = selector.predictor
    if predictor is None:
        raise SystemExit("no model is in use")
    many = [event(EVENTS + number, random) for number in range(10_000 - EVENTS)]
    for one in many:
        episodes.apply(Admitted(event=one))
        episodes.apply(Gained(experience=gained_of(one)))
    rows = [selector.encoder.encode(one) for one in events]
    forward = bare(selector.encoder.size)
    # Each call gets an event that the selector has not just seen, so that its memory of the last one doesn't help.
    calls: dict[str, Callable[[int], object]] = {
        "floor: bare numpy forward": lambda i: forward(rows[i]),
        "encode": lambda i: selector.encoder.encode(events[i]),
        "estimate": lambda i: predictor.estimate(rows[i]),
        "decide by guidelines": lambda i: plain.decide(events[i], {}, (), 0),
        "decide by model (encode and estimate in it)": lambda i: selector.decide(events[i], {}, (), 0),
        "nearest 5 of 10,000 experiences": lambda i: episodes.nearest(rows[i], 5),
        "why: contributions of all fields": lambda i: contributions(selector.encoder, predictor, events[i], TREATMENTS[0]),
    }
    spent: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(ROUNDS):
        for name, call in calls.items():
            for i in range(0, EVENTS, 8):
                begun = time.perf_counter()
                call(i)
                spent[name].append((time.perf_counter() - begun) * 1e6)
    print(f"{selector.encoder.size} features, {len(TREATMENTS)} treatments, {len(learning.rows)} experiences; times in µs")
    print(f"{'':46}{'median':>9}{'p10':>9}{'p90':>9}{'× floor':>9}")
    floor = float(np.median(spent["floor: bare numpy forward"]))
    for name, times in spent.items():
        low, middle, high = np.percentile(times, [10, 50, 90])
        print(f"{name:46}{middle:9.1f}{low:9.1f}{high:9.1f}{middle / floor:9.1f}")
    print(
        f"a first training: {card.epochs} epochs over {card.watermark} experiences in {trained_s:.2f} s, {len(weights):,} bytes"
    )


def gained_of(one: Event) -> Experience:
    """An experience of the event, for the memory's size alone."""
    return Experience(
        id=one.position, event=one.id, process=one.position, treatment=TREATMENTS[0], treatment_label=TREATMENTS[0],
        predicted="none", outcome="none", verdict=Verdict.SUPPORTED, mode="auto",
    )  # fmt: skip


if __name__ == "__main__":
    main()

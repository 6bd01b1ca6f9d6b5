"""Experiment 1's methods: what each one chooses for every test event, automatically or by asking."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

import numpy as np

from wakeful.contracts.learner import Vector
from wakeful.experiments.exp1_asking import Asking
from wakeful.experiments.exp1_events import events, labels_of, paper_inputs
from wakeful.experiments.worlds.service_events import TREATMENTS, Case, World
from wakeful.facts.events import Event
from wakeful.facts.values import Fact
from wakeful.learning.calibration import CANDIDATES
from wakeful.learning.material import Material
from wakeful.learning.network import Fit, Shape, logits, softmax, start, train


class Choice(Fact, frozen=True):
    """What one method did with one event. ``treatment`` is empty where it gave it none. ``confidence``: of the learned part."""

    treatment: str
    automatic: bool = False
    asked: bool = False
    confidence: float | None = None
    learned: str = ""
    """What the learned part would have chosen, asked or not."""
    guaranteed: bool = False
    """Whether the guarantee gate would have let it be automatic (``exp1_guaranteed``)."""


class Trial(Fact, frozen=True):
    """One seed's world with everything that several methods need of it, so that it is made once."""

    world: World
    calibration: tuple[Event, ...]
    test: tuple[Event, ...]
    advice: Mapping[str, str]
    """The reasoner's treatment by event id, for calibration and test events. A method that asks counts its calls itself."""
    guidelines: Mapping[str, str]
    confidences: tuple[tuple[float, ...], ...] = ()


def trial(world: World, asking: Asking) -> Trial:
    """Ask once what several methods may use."""
    calibration, test = events(world, "calibration"), events(world, "test")
    return Trial(
        world=world,
        calibration=calibration,
        test=test,
        advice=asking.answers(world, (*calibration, *test)),
        guidelines=asking.guidelines(test),
    )


Method = Callable[[Trial], list[Choice]]

# --- the paper's baselines ---

_BY_OBJECT: Final = {"item": "description", "obstacle": "risk_prediction", "device": "diagnosis", "unknown": "risk_prediction"}


def task_only(given: Trial) -> list[Choice]:
    """Nothing outside task and safety; there planning where the route is blocked, else risk prediction."""

    def one(case: Case) -> Choice:
        if not case.task_safety:
            return Choice(treatment="")
        return Choice(treatment="planning" if case.route == "blocking" else "risk_prediction")

    return [one(case) for case in given.world.test]


def fixed(given: Trial) -> list[Choice]:
    """One treatment per category of object."""
    return [Choice(treatment=_BY_OBJECT[case.category]) for case in given.world.test]


def always_llm(given: Trial) -> list[Choice]:
    """The reasoner, for every event."""
    return [Choice(treatment=given.advice.get(event.id, ""), asked=True) for event in given.test]


def guidelines(given: Trial) -> list[Choice]:
    """The product's offline reasoner over the domain's written guidelines, for every event."""
    return [Choice(treatment=given.guidelines.get(event.id, ""), asked=True) for event in given.test]


def paper_network(world: World) -> Callable[[tuple[Case, ...]], Vector]:
    """The paper's selector: two hidden layers of 64, ReLU, dropout 0.1, AdamW 1e-3, weight decay 1e-4, 140 epochs.

    Returns:
        A function from events to probabilities (n, 6), neither calibrated nor standardised.
    """
    x, y = paper_inputs(world.training), labels_of(world.training)
    none, ones = np.full(len(x), -1), np.ones(len(x))
    rows = Material(x=x, treatment=y, result=none, refuted=none, weight=ones, result_weight=ones)
    shape = Shape(inputs=x.shape[1], hidden=64, treatments=len(TREATMENTS), labels=1)
    *_, theta = train(start(shape, world.seed), shape, rows, Fit(epochs=140, seed=world.seed))
    return lambda cases: softmax(logits(theta, shape, paper_inputs(cases))[0])


def networked(given: Trial) -> tuple[list[Choice], list[Choice], list[Choice]]:
    """``dl_only`` and ``proposed``: the same trained network, alone and with doubtful events left to the reasoner; and what it
    says of the calibration events."""
    probabilities = paper_network(given.world)
    alone, told = _said(probabilities(given.world.test)), _said(probabilities(given.world.calibration))
    threshold = paper_threshold(given, told)
    return alone, _deferred(alone, given.test, given.advice, lambda choice: (choice.confidence or 0.0) < threshold), told


def paper_threshold(given: Trial, calibration: Sequence[Choice]) -> float:
    """The paper's threshold: of 0.45 … 0.90 the one with the most right on calibration events, of equal ones the least."""
    best = (-1, 0.0)
    for threshold in reversed(CANDIDATES):
        mixed = _deferred(calibration, given.calibration, given.advice, _below(threshold))
        right = sum(choice.treatment == case.truth for choice, case in zip(mixed, given.world.calibration, strict=True))
        if right >= best[0]:
            best = (right, threshold)
    return best[1]


def _below(threshold: float) -> Callable[[Choice], bool]:
    return lambda choice: (choice.confidence or 0.0) < threshold


def _said(probabilities: Vector) -> list[Choice]:
    names = [TREATMENTS[int(place)] for place in probabilities.argmax(axis=1)]
    return [
        Choice(treatment=name, learned=name, automatic=True, confidence=round(float(row.max()), 6))
        for name, row in zip(names, probabilities, strict=True)
    ]


def _deferred(
    learned: Sequence[Choice], asked: Sequence[Event], advice: Mapping[str, str], doubtful: Callable[[Choice], bool]
) -> list[Choice]:
    """The reasoner's treatment where the learned choice is doubtful; the learned one all the same where it refused."""
    return [
        Choice(treatment=advice.get(event.id, choice.treatment), learned=choice.learned, asked=True, confidence=choice.confidence)
        if doubtful(choice)
        else choice
        for choice, event in zip(learned, asked, strict=True)
    ]


def oracle_deferral(given: Trial, learned: Sequence[Choice]) -> list[Choice]:
    """What no gate can beat with this selector and this reasoner: asks exactly where asking turns wrong into right."""
    return [
        Choice(treatment=case.truth, learned=choice.learned, asked=True, confidence=choice.confidence)
        if choice.learned != case.truth and given.advice.get(event.id) == case.truth
        else Choice(treatment=choice.learned, learned=choice.learned, automatic=True, confidence=choice.confidence)
        for choice, case, event in zip(learned, given.world.test, given.test, strict=True)
    ]

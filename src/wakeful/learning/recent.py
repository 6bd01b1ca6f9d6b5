"""Recent experience joins the result head's forecast where the model proves wrong: what drifts is followed between two trainings.

A model version is as old as its training. The forecasters of ``windows.py`` are as young as the last outcome, so that where the
world drifts faster than models are made they know better, and elsewhere worse. How far each is heard follows from how well each
foretold, outcome by outcome.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import Final

import msgspec
import numpy as np

from wakeful.contracts.learner import Vector
from wakeful.facts.choices import Choice
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import AnyRecord, Decided
from wakeful.learning.episodes import Encode
from wakeful.learning.network import softmax
from wakeful.learning.windows import WINDOWS, EncodeMany, Windows

ERRS: Final = 0.1
"""Recent experience is asked while the model's forecast is wrong more often than this; else the model is right enough."""
BETTER: Final = 1.0
"""It is heard while it has saved so many nats of log loss, lately, over the model alone."""
OUTDONE: Final = 2.0
"""Exemplar memory is not asked once its forecasts erred so many times more often than these, lately."""
_ERRORS_KEPT: Final = 0.98
_RECORD_KEPT: Final = 0.998
_SAVED_KEPT: Final = 0.99
_ALL: Final = 100
_SELDOM: Final = 4
"""After ``_ALL`` comparisons every fourth outcome is compared, while nothing is heard: noise alone must not cost so much."""
_RECORD_LIMIT: Final = 40.0
_STEP: Final = 0.003
_FIRST_STEP: Final = 0.1
_LEAST: Final = 0.04
_DIGITS: Final = 6
_PENDING: Final = 10_000


class _Asked(msgspec.Struct, frozen=True):
    """A decision by a model: how many experiences there were, what the model alone forecast, and what memory said instead."""

    count: int
    prior: tuple[float, ...]
    recalled: int = -1


class Recent:
    """Windows of recent experience and their weights beside the model's. State is the fold of Decided and Gained.

    Forecasts are pooled by their weighted geometric mean, the model's weight being 1 and the others' 0 at first; each judged
    forecast moves the weights down the slope of its log loss, by steps that shrink to a floor so that they can go on following
    (online gradient descent, Zinkevich 2003). What is compared with an outcome is what was known when its event was decided on,
    however late the outcome came.

    Args:
        encode: the selector's encoder.
        encode_many: the same for many events.
        labels: the domain's outcome labels.
    """

    def __init__(self, encode: Encode, encode_many: EncodeMany, labels: tuple[str, ...]) -> None:
        self.labels = labels
        self._encode = encode
        self._label_at = {name: index for index, name in enumerate(labels)}
        self._windows = Windows(encode_many, len(labels))
        self._asked: OrderedDict[int, _Asked] = OrderedDict()
        self._weights = np.eye(1 + len(WINDOWS))[0]
        self._steps = 0
        self._errors = 0.0
        self._outdone = 0.0
        self._saved = 0.0

    @property
    def weights(self) -> tuple[float, ...]:
        """Of the model, then of each of ``windows.WINDOWS``."""
        return tuple(np.round(self._weights, _DIGITS).tolist())

    @property
    def heard(self) -> bool:
        """Whether the model's forecasts are joined by recent experience now."""
        return self._errors > ERRS and self._saved > BETTER

    @property
    def outdoes_memory(self) -> bool:
        """Whether these forecasts have been right where exemplar memory, which took their place, was wrong: what was told last of
        a sufficiently similar event is then not what comes next."""
        return self._outdone > OUTDONE

    def join(self, prior: tuple[float, ...], features: Vector) -> Vector:
        """The forecast to decide with, over ``labels``. Asking changes nothing.

        Args:
            prior: the model's.
            features: of the event, shape (d,).
        """
        shares = self._windows.shares(features, self._windows.count) if self.heard else None
        if shares is None:
            return np.array(prior)
        return np.round(softmax(self._weights @ self._logs(np.array(prior), shares)), _DIGITS)

    def says(self, prior: Mapping[str, float]) -> str:
        """In words, that the model is not alone: ``prior`` is what it forecast by itself."""
        label = max(prior, key=lambda name: prior[name])
        share = float(self._weights[1:].sum() / max(self._weights.sum(), 1e-9))
        return (
            f"The model's forecasts have been wrong in {self._errors:.0%} of late, so recent experience joins them "
            f"({share:.0%} of the weight); alone the model says {label!r} with {prior[label]:.3f}."
        )

    def covered(self, process: int, choice: Choice) -> None:
        """Take up an automatic decision by a model alone, as ``apply`` of its Decided does."""
        labels, prior = choice.basis.labels, choice.prior
        if labels != self.labels:
            named = dict(zip(labels, prior, strict=True))
            prior = tuple(named.get(name, 0.0) for name in self.labels)
        self._ask(process, prior)

    def apply(self, record: AnyRecord) -> None:
        """Take up a process's first Decided (deliberation decides again); all else passes by."""
        if isinstance(record, Decided) and record.decision.model and record.process not in self._asked:
            made = record.decision
            own = made.foretold or made.prior
            recalled = made.recalled and made.foretold and made.prior
            said = max(made.prior, key=lambda name: made.prior[name]) if recalled else ""
            self._ask(record.process, tuple(own.get(name, 0.0) for name in self.labels), self._label_at.get(said, -1))

    def gain(self, experience: Experience, event: Event) -> None:
        """Take up an experience: who foretold it how well, and then the experience itself."""
        label = -1 if experience.verdict is Verdict.UNDECIDED else self._label_at.get(experience.outcome, -1)
        if label < 0:
            return
        asked = self._asked.pop(experience.process, None)
        best = max(asked.prior) if asked is not None else 0.0
        if asked is not None and best > 0.0:
            self._errors *= _ERRORS_KEPT
            if best > asked.prior[label]:
                self._errors += 1.0 - _ERRORS_KEPT
            if self._errors > ERRS or asked.recalled >= 0:
                self._compare(asked, experience, event, label)
            elif self._outdone:
                self._outdone *= _RECORD_KEPT
        self._windows.add(event, label)

    def _compare(self, asked: _Asked, experience: Experience, event: Event, label: int) -> None:
        """Windows with the model, and memory with both where it had spoken for them."""
        asks = self._errors > ERRS and (self._steps < _ALL or self.heard or experience.id % _SELDOM == 0)
        said = self._judge(asked, event, label) if asks else asked.prior.index(max(asked.prior))
        more = 0 if asked.recalled < 0 else (asked.recalled != label) - (said != label)
        self._outdone = min(max(_RECORD_KEPT * self._outdone + more, -OUTDONE), _RECORD_LIMIT)

    def _judge(self, asked: _Asked, event: Event, label: int) -> int:
        """Move the weights by what each said of an event that came to ``label``; what all of them said together."""
        shares = self._windows.shares(self._encode(event), asked.count)
        if shares is None:
            return asked.prior.index(max(asked.prior))
        self._steps += 1
        logs = self._logs(np.array(asked.prior), shares)
        together = softmax(self._weights @ logs)
        alone = softmax(logs[0])  # what is said where nothing joins it
        self._saved = round(_SAVED_KEPT * self._saved + float(np.log(together[label] / alone[label])), _DIGITS)
        step = max(_STEP, _FIRST_STEP / self._steps**0.5)
        self._weights = np.round(np.maximum(self._weights - step * (logs @ together - logs[:, label]), 0.0), _DIGITS)
        return int(together.argmax())

    def _logs(self, prior: Vector, shares: Vector) -> Vector:
        """Logarithms about their mean, so that a weight says how sharply a forecaster tells labels apart."""
        logs = np.log(np.maximum(np.vstack([prior, shares]), _LEAST / len(self.labels)))
        return np.asarray(logs - logs.mean(axis=1, keepdims=True))

    def _ask(self, process: int, prior: tuple[float, ...], recalled: int = -1) -> None:
        self._asked[process] = _Asked(self._windows.count, prior, recalled)
        if len(self._asked) > _PENDING:
            self._asked.popitem(last=False)

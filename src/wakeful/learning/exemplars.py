"""Exemplar memory beside the network: one validated experience suffices for the next event that is sufficiently similar.

An exemplar stands for one event as it was met again and again. It holds what its validations have told so far, as a belief
(`Belief`) over treatments and over outcomes: where validations have proved reliable one contradiction turns it, where they are
noisy it takes more. How noisy they are is learned from all exemplars together.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final

import numpy as np

from wakeful.contracts.learner import Predictor, Vector
from wakeful.facts.choices import Choice
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import AnyRecord, Decided, Gained
from wakeful.facts.recollection import Recollection
from wakeful.learning.alike import Alike
from wakeful.learning.belief import Expected, Repeatability
from wakeful.learning.episodes import Encode
from wakeful.learning.exemplar import AT_MOST, TOLD, Foretold, Teacher, Told

NOISY: Final = 0.25
"""Where more validations than this seem wrong, a model that is sure is not gainsaid."""

_PENDING = 10_000
_DIGITS = 6


_NOTHING: Final = Foretold()


def _was_known(experience: Experience, recalled: int, foretold: Foretold) -> bool:
    """Whether it only shows what the model knew: automatic by its word alone, and supported."""
    by_model = bool(foretold.shares) and not recalled
    return by_model and experience.mode == "auto" and experience.verdict is Verdict.SUPPORTED


class Exemplars:
    """At most ``limit`` exemplars; past that the ones least recently validated are forgotten. State is the fold of records.

    Two events are sufficiently similar where they agree in every category and differ only in numbers for which the model would
    not think about them in another way: what an event's numbers mean is learned, which category it is in is given. Its forecast
    does not tell them apart, since that is what memory may have to correct.

    Args:
        encode: the selector's encoder; columns in which nothing but 0 and 1 was seen are categories.
        treatments: all registered treatments, in a fixed order.
        labels: the domain's outcome labels.
        limit: how many exemplars are remembered.
        expected: how noisy and how changing the world is held to be at first.
    """

    def __init__(
        self,
        encode: Encode,
        treatments: tuple[str, ...],
        labels: tuple[str, ...],
        limit: int = 4096,
        expected: Expected | None = None,
    ) -> None:
        self.treatments, self.labels, self.limit = treatments, labels, limit
        self._encode = encode
        self._treatment_at = {name: index for index, name in enumerate(treatments)}
        self._label_at = {name: index for index, name in enumerate(labels)}
        self._teacher = Teacher(len(treatments), len(labels), expected)
        self._alike = Alike(treatments, labels)
        self._decided: OrderedDict[int, tuple[int, Foretold]] = OrderedDict()
        self._taught: OrderedDict[int, int] = OrderedDict()
        self._now = 0
        self._reviewed: Predictor | None = None
        self._watched: set[bytes] = set()

    def __len__(self) -> int:
        return len(self._alike)

    @property
    def treatment_repeats(self) -> Repeatability:
        """How noise and change have shown in the right treatments that were told."""
        return self._teacher.treatment_repeats

    @property
    def label_repeats(self) -> Repeatability:
        """The same of outcomes."""
        return self._teacher.label_repeats

    @property
    def noise(self) -> float:
        """The expected share of wrong validations of outcomes."""
        return round(self.label_repeats.noise, _DIGITS)

    def recall(self, features: Vector, predictor: Predictor | None) -> Recollection | None:
        """What is remembered of events like this one, shape (d,); None where there is none that is sufficiently similar.

        Args:
            features: of the event at hand.
            predictor: the model version in use; without one only equal numbers are alike.
        """
        alike = self._alike.to(features, predictor) if len(self._alike) else []
        if not alike:
            return None
        likeness, likest = alike[0]
        exemplar = likest if len(alike) == 1 else self._teacher.together([each for _, each in alike])
        # The event at hand would be validated next: that far everything may have changed.
        at = self._now + 1
        treatments = exemplar.treatment.shares(at, self.treatment_repeats)
        labels = exemplar.label.shares(at, self.label_repeats)
        right = int(treatments.argmax())
        return Recollection(
            exemplar=likest.id,
            experiences=tuple(told.id for told in exemplar.told[:-4:-1]),
            likeness=likeness,
            treatment=self.treatments[right] if exemplar.treatment.told else "",
            treatment_share=round(float(treatments[right]), _DIGITS),
            labels=dict(zip(self.labels, np.round(labels, _DIGITS).tolist(), strict=True)) if exemplar.label.told else {},
            noise=round(exemplar.label.noise(self.label_repeats), _DIGITS),
            contradicted=exemplar.told[-1].label not in (-1, int(labels.argmax())),
            confirmed=any(told.treatment == right and told.label in (-1, int(labels.argmax())) for told in exemplar.told),
        )

    def disputes(self, predictor: Predictor | None) -> bool:
        """Whether memory may hold otherwise than the model version in use of anything at all: mostly not, and said at once."""
        if predictor is not self._reviewed:
            self._review(predictor)
        return bool(self._watched) and self.label_repeats.noise <= NOISY

    def covered(self, process: int, choice: Choice) -> None:
        """Take up an automatic decision by a model, as ``apply`` of its Decided does."""
        labels = choice.basis.labels
        if labels == self.labels:
            prior = choice.prior
        else:
            named = dict(zip(labels, choice.prior, strict=True))
            prior = tuple(named.get(name, 0.0) for name in self.labels)
        self._decided[process] = (0, Foretold(prior, choice.basis.watermark))
        if len(self._decided) > _PENDING:
            self._decided.popitem(last=False)

    def gain(self, experience: Experience, event: Event) -> None:
        """Take up an experience, as ``apply`` of its Gained does."""
        recalled, foretold = self._decided.get(experience.process, (0, _NOTHING))
        if _was_known(experience, recalled, foretold):
            self._known(experience, foretold)
        else:
            self._learn(experience, self._encode(event), recalled, foretold)

    def contested(self, features: Vector, predictor: Predictor | None) -> bool:
        """Whether memory holds otherwise than the model of some event of the same categories: then it is to be asked, however
        sure the model is."""
        if predictor is None:
            return True
        pattern = self._alike.pattern(features)
        if not self.disputes(predictor) or pattern not in self._watched:
            return False
        if self._alike.is_disputed(pattern, predictor):
            return True
        self._watched.discard(pattern)
        return False

    def apply(self, record: AnyRecord, event: Event | None = None) -> None:
        """Take up a record; all but Decided and Gained are passed over, and Gained where its event is no longer known."""
        if isinstance(record, Decided):
            decision = record.decision
            prior = tuple(decision.prior.get(name, 0.0) for name in self.labels)
            # Deliberation decides again, and doesn't say what memory had said.
            earlier, _ = self._decided.get(record.process, (0, _NOTHING))
            known = decision.model and not decision.recalled and decision.mode != "fallback"
            self._decided[record.process] = (
                decision.recalled or earlier,
                Foretold(prior, decision.watermark) if known else _NOTHING,
            )
            if len(self._decided) > _PENDING:
                self._decided.popitem(last=False)
        elif isinstance(record, Gained) and event is not None:
            self.gain(record.experience, event)

    def learn(self, experience: Experience, features: Vector, recalled: int = 0) -> None:
        """One validated experience of an event that no model had a say in.

        Args:
            experience: the outcome of an undecided one teaches nothing.
            features: of its event, shape (d,).
            recalled: the exemplar that its decision had rested on, 0 for none.
        """
        self._learn(experience, features, recalled, _NOTHING)

    def _learn(self, experience: Experience, features: Vector, recalled: int, foretold: Foretold) -> None:
        treatment = self._treatment_at.get(experience.treatment_label, -1)
        label = -1 if experience.verdict is Verdict.UNDECIDED else self._label_at.get(experience.outcome, -1)
        self._now = max(self._now, experience.id)
        if treatment < 0 and label < 0:
            return
        told = Told(experience.id, experience.process, treatment, label, foretold)
        if self._alike.see(features):
            self._reviewed = None
        exemplar = self._alike.get(recalled) or self._alike.same(features)
        if exemplar is None:
            exemplar = self._teacher.found(told, features)
            self._watched.discard(self._alike.add(exemplar, self.limit) or b"")
        if self._taught.get(told.process) == exemplar.id:
            self._teacher.again(exemplar, told)
        else:
            self._teacher.teach(exemplar, told)
        self._taught[told.process] = exemplar.id
        if len(self._taught) > _PENDING:
            self._taught.popitem(last=False)
        if not np.array_equal(exemplar.features, features):
            exemplar.features, exemplar.estimate = features.copy(), None
        self._alike.validated(exemplar)
        self._watched.add(self._alike.pattern(features))
        del exemplar.told[:-TOLD]

    def _known(self, experience: Experience, foretold: Foretold) -> None:
        """The model knew it: nothing to remember, but that much about how reliable validations are."""
        self._now = max(self._now, experience.id)
        label = self._label_at.get(experience.outcome, -1)
        if label >= 0:
            share = min(max(foretold.shares[label], 1.0 - AT_MOST), AT_MOST)
            self.label_repeats.foretold(share, len(self.labels), experience.id - foretold.since)

    def _review(self, predictor: Predictor | None) -> None:
        """Another model version is in use: what it says is compared at once where that is cheap, else as events come."""
        self._reviewed = predictor
        self._watched = self._alike.disputed(predictor)

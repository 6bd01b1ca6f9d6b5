"""Exemplar memory beside the network: one validated experience suffices for the next event that is sufficiently similar.

An exemplar stands for one event as it was met again and again. It holds what its validations have told so far, as a belief
(`Belief`) over treatments and over outcomes: where validations have proved reliable one contradiction turns it, where they are
noisy it takes more. How noisy they are is learned from all exemplars together.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Predictor, RowPredictor, Vector
from wakeful.facts.choices import Choice
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import AnyRecord, Decided, Gained
from wakeful.facts.recollection import Recollection
from wakeful.learning.belief import Belief, Expected, Repeatability
from wakeful.learning.episodes import Encode

LIKE_ENOUGH: Final = 0.6
"""How alike two events must be that agree in every category: 1 less the total variation of the model's shares of treatments."""
CLOSE: Final = 1e-3
"""Numbers that differ by no more are the same, model or not."""
NOISY: Final = 0.25
"""Where more validations than this seem wrong, a model that is sure is not gainsaid."""
AT_MOST: Final = 0.95
"""No forecast is held to be surer than this: a model that is wrong must not look like an outcome that was told wrongly."""

_PER_PATTERN = 16
_PENDING = 10_000
_TOLD = 16
_DIGITS = 6


class _Foretold(msgspec.Struct, frozen=True):
    """What a model forecast, over the labels, and the last experience that it had learned from; empty where none had a say."""

    shares: tuple[float, ...] = ()
    since: int = 0


class _Told(msgspec.Struct, frozen=True):
    id: int
    process: int
    treatment: int
    label: int
    foretold: _Foretold


class _Exemplar(msgspec.Struct):
    id: int
    features: Vector
    told: list[_Told]
    treatment: Belief
    label: Belief
    estimate: tuple[object, Vector] | None = None
    """A model version, and what its two heads say of it."""
    newest: tuple[int, int] = (-1, -1)
    """The treatment and the outcome that were told last, -1 where not."""


_NOTHING: Final = _Foretold()


def _was_known(experience: Experience, recalled: int, foretold: _Foretold) -> bool:
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
        self._expected = expected
        self.treatment_repeats, self.label_repeats = Repeatability(expected), Repeatability(expected)
        self._exemplars: OrderedDict[int, _Exemplar] = OrderedDict()
        self._like: dict[bytes, list[int]] = {}
        self._numeric: npt.NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)
        self._decided: OrderedDict[int, tuple[int, _Foretold]] = OrderedDict()
        self._taught: OrderedDict[int, int] = OrderedDict()
        self._now = 0
        self._reviewed: Predictor | None = None
        self._watched: set[bytes] = set()

    def __len__(self) -> int:
        return len(self._exemplars)

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
        if not self._exemplars:
            return None
        alike = self._alike(features, predictor)
        if not alike:
            return None
        likeness, likest = alike[0]
        exemplar = likest if len(alike) == 1 else self._together([each for _, each in alike])
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
        self._decided[process] = (0, _Foretold(prior, choice.basis.watermark))
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
        pattern = self._pattern(features)
        if not self.disputes(predictor) or pattern not in self._watched:
            return False
        if self._disputed(pattern, predictor):
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
                _Foretold(prior, decision.watermark) if known else _NOTHING,
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

    def _learn(self, experience: Experience, features: Vector, recalled: int, foretold: _Foretold) -> None:
        treatment = self._treatment_at.get(experience.treatment_label, -1)
        label = -1 if experience.verdict is Verdict.UNDECIDED else self._label_at.get(experience.outcome, -1)
        self._now = max(self._now, experience.id)
        if treatment < 0 and label < 0:
            return
        told = _Told(experience.id, experience.process, treatment, label, foretold)
        self._see(features)
        exemplar = self._exemplars.get(recalled) or self._same(features) or self._found(told, features)
        if self._taught.get(told.process) == exemplar.id:
            # The world was heard late: what this process taught before is taken back.
            self._again(exemplar, told)
        else:
            self._teach(exemplar, told, self.treatment_repeats, self.label_repeats)
            exemplar.told.append(told)
        self._taught[told.process] = exemplar.id
        if len(self._taught) > _PENDING:
            self._taught.popitem(last=False)
        if not np.array_equal(exemplar.features, features):
            exemplar.features, exemplar.estimate = features.copy(), None
        self._exemplars.move_to_end(exemplar.id)
        self._watched.add(self._pattern(features))
        del exemplar.told[:-_TOLD]

    def _known(self, experience: Experience, foretold: _Foretold) -> None:
        """The model knew it: nothing to remember, but that much about how reliable validations are."""
        self._now = max(self._now, experience.id)
        label = self._label_at.get(experience.outcome, -1)
        if label >= 0:
            share = min(max(foretold.shares[label], 1.0 - AT_MOST), AT_MOST)
            self.label_repeats.foretold(share, len(self.labels), experience.id - foretold.since)

    def _review(self, predictor: Predictor | None) -> None:
        """Another model version is in use: what it says is compared at once where that is cheap, else as events come."""
        self._reviewed = predictor
        self._watched = set(self._like)
        if isinstance(predictor, RowPredictor) and self._exemplars:
            rows = predictor.estimate_rows(np.stack([each.features for each in self._exemplars.values()]))
            for each, heads in zip(self._exemplars.values(), np.hstack([rows.treatments, rows.labels]), strict=True):
                each.estimate = (predictor, heads)
            self._watched = {pattern for pattern in self._like if self._disputed(pattern, predictor)}

    def _teach(self, exemplar: _Exemplar, told: _Told, treatments: Repeatability, labels: Repeatability) -> None:
        if told.treatment >= 0:
            exemplar.treatment.learn(told.treatment, told.id, treatments)
        if told.label >= 0:
            exemplar.label.learn(told.label, told.id, labels)
        exemplar.newest = (told.treatment, told.label)

    def _again(self, exemplar: _Exemplar, told: _Told) -> None:
        exemplar.told = [told if one.process == told.process else one for one in exemplar.told]
        self._replay(exemplar)

    def _replay(self, exemplar: _Exemplar) -> None:
        self._begin(exemplar, exemplar.told[0])
        aside = Repeatability(self._expected), Repeatability(self._expected)
        for one in exemplar.told:
            self._teach(exemplar, one, *aside)

    def _found(self, told: _Told, features: Vector) -> _Exemplar:
        exemplar = _Exemplar(told.id, features.copy(), [], Belief(np.ones(1), 0), Belief(np.ones(1), 0))
        self._begin(exemplar, told)
        self._exemplars[exemplar.id] = exemplar
        self._like.setdefault(self._pattern(features), []).append(exemplar.id)
        if len(self._exemplars) > self.limit:
            self._forget(next(iter(self._exemplars)))
        return exemplar

    def _begin(self, exemplar: _Exemplar, told: _Told) -> None:
        exemplar.treatment = Belief(np.full(len(self.treatments), 1.0 / len(self.treatments)), told.id)
        even = np.full(len(self.labels), 1.0 / len(self.labels))
        shares = told.foretold.shares
        if shares:
            first = np.clip(shares, 1.0 - AT_MOST, AT_MOST)
            exemplar.label = Belief(first / first.sum(), told.foretold.since)
        else:
            exemplar.label = Belief(even, told.id)

    def _same(self, features: Vector) -> _Exemplar | None:
        alike = self._alike(features, None)
        return alike[0][1] if alike else None

    def _alike(self, features: Vector, predictor: Predictor | None) -> list[tuple[float, _Exemplar]]:
        """The exemplars that are like enough with how like they are, the likest first, of equally like ones the last founded."""
        found: list[tuple[float, _Exemplar]] = []
        own: Vector | None = None
        for identity in reversed(self._like.get(self._pattern(features), ())[-_PER_PATTERN:]):
            exemplar = self._exemplars[identity]
            if float(np.abs(exemplar.features - features).max()) <= CLOSE:
                # The very same event: what others like it were is beside the point.
                return [(1.0, exemplar)]
            if predictor is not None:
                own = self._heads(predictor, features) if own is None else own
                cut = len(predictor.treatments)
                likeness = round(1.0 - 0.5 * float(np.abs(own - self._foreseen(exemplar, predictor))[:cut].sum()), _DIGITS)
                if likeness >= LIKE_ENOUGH:
                    found.append((likeness, exemplar))
        return sorted(found, key=lambda pair: (-pair[0], -pair[1].id))

    def _together(self, alike: list[_Exemplar]) -> _Exemplar:
        """What was told of all of these, in the order in which it was, as one exemplar."""
        told = sorted((one for each in alike for one in each.told), key=lambda one: one.id)[-_TOLD:]
        whole = _Exemplar(told[0].id, alike[0].features, told, Belief(np.ones(1), 0), Belief(np.ones(1), 0))
        self._replay(whole)
        return whole

    def _foreseen(self, exemplar: _Exemplar, predictor: Predictor) -> Vector:
        if exemplar.estimate is None or exemplar.estimate[0] is not predictor:
            exemplar.estimate = (predictor, self._heads(predictor, exemplar.features))
        return exemplar.estimate[1]

    def _disputed(self, pattern: bytes, predictor: Predictor) -> bool:
        """Whether the last word on some event of these categories was another than the model's, or than that on another one."""
        alike = [self._exemplars[each] for each in self._like.get(pattern, ())]
        return len({each.newest for each in alike}) > 1 or any(self._differs(each, predictor) for each in alike)

    def _differs(self, exemplar: _Exemplar, predictor: Predictor) -> bool:
        """Whether the model says otherwise of the exemplar itself than what was told last of it."""
        heads, cut = self._foreseen(exemplar, predictor), len(predictor.treatments)
        treatment, label = exemplar.newest
        return (treatment >= 0 and predictor.treatments[int(heads[:cut].argmax())] != self.treatments[treatment]) or (
            label >= 0 and predictor.labels[int(heads[cut:].argmax())] != self.labels[label]
        )

    def _heads(self, predictor: Predictor, features: Vector) -> Vector:
        estimate = predictor.estimate(features)
        return np.concatenate([estimate.treatments, estimate.labels])

    def _see(self, features: Vector) -> None:
        """Columns with other numbers than 0 and 1 are no categories, from now on."""
        numeric = (features != 0.0) & (features != 1.0)
        if not len(self._numeric):
            self._numeric = numeric
        elif (numeric & ~self._numeric).any():
            self._numeric = self._numeric | numeric
            self._like = {}
            self._reviewed = None
            for exemplar in self._exemplars.values():
                self._like.setdefault(self._pattern(exemplar.features), []).append(exemplar.id)

    def _pattern(self, features: Vector) -> bytes:
        return np.packbits((features == 1.0) & ~self._numeric).tobytes()

    def _forget(self, identity: int) -> None:
        gone = self._exemplars.pop(identity)
        pattern = self._pattern(gone.features)
        left = [each for each in self._like.get(pattern, ()) if each != identity]
        if left:
            self._like[pattern] = left
        else:
            self._like.pop(pattern, None)
            self._watched.discard(pattern)

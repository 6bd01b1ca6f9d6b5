"""Continual learning as the kernel runs it: when a training is due, and what it learns from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import msgspec
import numpy as np

from wakeful.contracts.learner import Learner, Vector
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.inputs import TrainingJob
from wakeful.facts.lines import Acted, AnyRecord, Compacted, Drifted, Gained, Imported, Published, TrainingAsked
from wakeful.facts.settings import MindSettings
from wakeful.facts.time import to_ns
from wakeful.learning.replay import Row, Sides, refuted, replay

Encode = Callable[[Event], Vector]
EncodeMany = Callable[[Sequence[Event]], Iterable[Vector]]

_UNMADE: Vector = np.zeros(0)


#: More experiences than any mind has.
NEVER = 1 << 60


class LearningSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """When and how a mind trains.

    The first training comes with ``min_experiences`` decided experiences, each later one after ``every`` more, or ``growth``
    times all there were if that is more. A contradiction of an automatic decision counts for ``contradiction_counts`` of them,
    so that a few are enough. ``epochs_first`` is from scratch, ``epochs`` a continual update (Section IV-A of the paper).
    ``latency_s`` is the declared time to publication in virtual time. ``replay`` bounds the rows of one training,
    ``remembered`` those that are kept at all; ``held_back`` is the share kept for comparison and calibration.
    ``corrective_weight`` is what an experience that corrected a result weighs. ``benefit``: thresholds may let pass what
    deliberation got wrong as often.
    """

    min_experiences: int = 20
    every: int = 25
    growth: float = 0.1
    contradiction_counts: int = 5
    epochs_first: int = 140
    epochs: int = 35
    latency_s: float = 2.0
    seed: int = 0
    replay: int = 512
    remembered: int = 20_000
    held_back: float = 0.2
    corrective_weight: float = 1.0
    benefit: bool = True

    @classmethod
    def under(cls, settings: MindSettings) -> LearningSettings:
        """The defaults, as the mind's gate needs them.

        Under the guarantee a new version comes when experience has doubled: a certificate is of one version, and must be
        earned anew by the next.
        """
        growth = 1.0 if settings.gate == "guarantee" else 0.1
        chosen = cls(seed=settings.seed, growth=growth, benefit=settings.gate == "benefit")
        return chosen if settings.trains else msgspec.structs.replace(chosen, min_experiences=NEVER)


class Learning:
    """Keeps the learning material and says when a training is due. All state is the fold of the records applied.

    Args:
        spec: the domain; its outcome labels are what the result head learns.
        treatments: all registered treatments, in a fixed order.
        learner: trains the jobs, off the kernel's thread.
        encode: the selector's encoder, so that learning sees what selection sees.
        settings: when and on how much.
        encode_many: the same encoder for many events at once, where there is one.
    """

    def __init__(
        self,
        spec: DomainSpec,
        treatments: tuple[str, ...],
        learner: Learner,
        encode: Encode,
        settings: LearningSettings | None = None,
        encode_many: EncodeMany | None = None,
    ) -> None:
        self.learner = learner
        self.treatments = treatments
        self.labels = spec.outcome.labels
        self.settings = settings or LearningSettings()
        self._encode_many = encode_many or (lambda events: [encode(event) for event in events])
        self._treatment_at = {name: index for index, name in enumerate(treatments)}
        self._label_at = {name: index for index, name in enumerate(self.labels)}
        self._rows: dict[int, Row] = {}
        self._side_of: dict[str, bool] = {}
        self._sides = Sides(self.settings.held_back)
        self._decided = 0
        self._since_asked = 0
        self._at_asked = 0
        self._watermark = 0
        self._trainings = 0
        self._base = 0
        self._pending: TrainingAsked | None = None
        self._frozen: tuple[Row, ...] = ()

    @property
    def pending(self) -> TrainingAsked | None:
        """The training that was asked for and not yet published."""
        return self._pending

    @property
    def watermark(self) -> int:
        """The id of the last experience."""
        return self._watermark

    @property
    def rows(self) -> tuple[Row, ...]:
        """The learning material, in the order of its ids."""
        return tuple(self._made(list(self._rows.values())))

    def apply(self, record: AnyRecord, event: Event | None = None) -> None:
        """Take up a record; all but Gained, Compacted, Imported, TrainingAsked, Published, Drifted and a rollback pass by.

        Args:
            record: the record, live or in recovery.
            event: the experience's event, with Gained.

        Raises:
            ValueError: Gained came without its event; nothing has changed.
        """
        if isinstance(record, Gained):
            if event is None or event.id != record.experience.event:
                raise ValueError(f"experience {record.experience.id} needs its event {record.experience.event}")
            self.gain(record.experience, event)
        elif isinstance(record, Compacted):
            self._watermark = max(self._watermark, record.experience)
            self._decided += record.gained
            self._since_asked += record.gained
        elif isinstance(record, Imported):
            # It is no process of this journal: its row has a place of its own.
            self.gain(msgspec.structs.replace(record.experience, process=-record.experience.id), record.event)
        elif isinstance(record, TrainingAsked):
            self._pending = record
            self._frozen = tuple(self._chosen(record.watermark))
            self._trainings = max(self._trainings, record.training)
            self._since_asked, self._at_asked = 0, self._decided
        elif isinstance(record, Published):
            if self._pending is not None and self._pending.training == record.training:
                self._pending, self._frozen = None, ()
            if record.card.accepted:
                self._base = record.card.version
        elif isinstance(record, Drifted):
            self._since_asked += self.settings.every  # what was learned no longer holds: learn again as soon as may be
        elif isinstance(record, Acted) and record.act == "rollback" and not record.refused:
            # What was being trained went on from the version that is no longer wanted.
            self._base, self._pending, self._frozen = record.version, None, ()

    def due(self, now_ns: int) -> TrainingAsked | None:
        """The training to ask for now, or None. At most one is under way. Asking changes nothing: applying does."""
        own = self.settings
        if self._pending is not None or self._decided < own.min_experiences or not self._since_asked:
            return None
        if self._trainings and self._since_asked < max(own.every, own.growth * self._at_asked):
            return None
        training = self._trainings + 1
        return TrainingAsked(
            training=training,
            base=self._base,
            watermark=self._watermark,
            seed=own.seed + training,
            epochs=own.epochs if self._base else own.epochs_first,
            publish_ns=now_ns + to_ns(own.latency_s),
        )

    def job(self, asked: TrainingAsked, base_weights: bytes) -> TrainingJob:
        """All that the training needs, made from the records up to its watermark alone.

        Args:
            asked: the training; where it is the pending one, its rows are those that stood when it was asked for.
            base_weights: the weights of version ``asked.base``; empty where that is 0.

        Returns:
            Rows in the order of their ids. A supported or told treatment is a label; one that is only contradicted is a
            negative where it, and not just its result, was wrong (see ``replay.refuted``); the result's label is always the
            outcome.
        """
        same = self._pending is not None and self._pending.training == asked.training
        rows: Sequence[Row] = self._frozen if same else self._chosen(asked.watermark)
        width = len(rows[0].features) if rows else 0
        return TrainingJob(
            training=asked.training,
            base_version=asked.base,
            base_weights=base_weights,
            watermark=asked.watermark,
            seed=asked.seed,
            epochs=asked.epochs,
            treatments=self.treatments,
            labels=self.labels,
            features=np.array([row.features for row in rows], dtype=np.float64).reshape(len(rows), width),
            treatment=np.array([row.label for row in rows], dtype=np.int64),
            result=np.array([row.result for row in rows], dtype=np.int64),
            refuted=refuted(rows),
            weight=np.array([row.weight for row in rows], dtype=np.float64),
            held_back=np.array([row.held_back for row in rows], dtype=np.bool_),
            right=np.array([row.right for row in rows], dtype=np.bool_) if self.settings.benefit else None,
        )

    def gain(self, experience: Experience, event: Event) -> None:
        """Take up an experience, as ``apply`` of its Gained does."""
        contradicted = experience.verdict is Verdict.CONTRADICTED
        label = self._treatment_at.get(experience.treatment_label, -1)
        result = -1 if experience.verdict is Verdict.UNDECIDED else self._label_at.get(experience.outcome, -1)
        self._watermark = max(self._watermark, experience.id)
        if label < 0 and result < 0:
            return
        applied = self._treatment_at.get(experience.treatment, -1)
        stratum = (label if label >= 0 else applied, result)
        held_back = self._sides.held_back(event.id, stratum, self._side_of.get(event.id))
        self._side_of[event.id] = held_back
        # The world was heard late: this experience of the process takes the place of its earlier one.
        self._rows.pop(experience.process, None)
        self._rows[experience.process] = Row(
            id=experience.id,
            event=event.id,
            process=experience.process,
            features=_UNMADE,
            label=label,
            applied=applied,
            result=result,
            contradicted=contradicted,
            weight=experience.weight * (self.settings.corrective_weight if contradicted else 1.0),
            held_back=held_back,
            source=event,
        )
        self._decided += 1
        automatic = contradicted and experience.mode == "auto"
        self._since_asked += self.settings.contradiction_counts if automatic else 1
        if len(self._rows) > self.settings.remembered + self.settings.remembered // 8:
            self._forget()

    def _forget(self) -> None:
        kept = replay(tuple(self._rows.values()), self.settings.remembered)
        self._rows = {row.process: row for row in kept}
        events = {row.event for row in kept}
        self._side_of = {event: side for event, side in self._side_of.items() if event in events}

    def _chosen(self, watermark: int) -> list[Row]:
        known = [row for row in self._rows.values() if row.id <= watermark]
        share = self.settings.held_back
        kept = replay([row for row in known if row.held_back], round(self.settings.replay * share / (1.0 - share)))
        learned = replay([row for row in known if not row.held_back], self.settings.replay)
        return self._made(sorted([*learned, *kept], key=lambda row: row.id))

    def _made(self, rows: list[Row]) -> list[Row]:
        """The rows with their features: made when a training wants them, many at once, and once only."""
        unmade = {row.process: row.source for row in rows if row.source is not None}
        if unmade:
            for process, features in zip(unmade, self._encode_many(list(unmade.values())), strict=True):
                self._rows[process] = msgspec.structs.replace(self._rows[process], features=features, source=None)
        return [self._rows[row.process] for row in rows]

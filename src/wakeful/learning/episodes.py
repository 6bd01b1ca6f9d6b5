"""Episodic memory: what was met, what was concluded and how it ended, searched by likeness. Exact up to 100,000 episodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import msgspec
import numpy as np
import numpy.typing as npt

from wakeful.contracts.learner import Vector
from wakeful.facts.asking import Episode, Query
from wakeful.facts.events import Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Admitted, AnyRecord, Concluded, Created, Gained, Imported, Judged
from wakeful.facts.packs import Ran
from wakeful.facts.results import Forecast
from wakeful.facts.values import NOTHING, Raw
from wakeful.learning.approximate import EXACT, LOOKED_AT, Approximate, installed

Encode = Callable[[Event], Vector]
EncodeMany = Callable[[Sequence[Event]], Vector]

_DIGITS: Final = 6
_FIRST_ROWS: Final = 64
_COLUMNS: Final = ("_norms", "_entities", "_kinds")

#: Features are written for so many events at a time, or when they are asked for.
TOGETHER: Final = 256


class _Said(msgspec.Struct):
    says: str = ""


class _Entry(msgspec.Struct, kw_only=True):
    event: Event
    order: int
    treatment: str = ""
    result: Raw = NOTHING
    predicted: str = ""
    outcome: str = ""
    verdict: str = ""
    experience: int = 0


class Episodes:
    """Remembers at most ``limit`` events; past that the oldest fifth is forgotten at once. State is the fold of records.

    Features are kept as float32 in one array that doubles when it is full. Candidates are found by one matrix product in
    float32 and then measured again in float64, so that the order is exact; distances are rounded to 6 digits, and equal
    ones go by newest, then by event id. Where more than ``exact`` are remembered and the extra ``memory`` is installed, the
    candidates come from an approximate index; what it finds is measured and ordered as before.
    """

    def __init__(self, encode: Encode, limit: int = 20_000, exact: int = EXACT, encode_many: EncodeMany | None = None) -> None:
        self.limit = limit
        self._exact = exact
        self._near: Approximate | None = None
        self._encode_many = encode_many or (lambda events: np.array([encode(event) for event in events]))
        self._waiting: list[Event] = []
        self._together = TOGETHER
        self._entries: list[_Entry] = []
        self._at: dict[str, int] = {}
        self._children: set[int] = set()
        self._rows: npt.NDArray[np.float32] = np.zeros((0, 0), dtype=np.float32)
        self._norms: npt.NDArray[np.float32] = np.zeros(0, dtype=np.float32)
        self._experienced = bytearray()
        self._concluded = bytearray()
        self._entities: npt.NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._kinds: npt.NDArray[np.int64] = np.zeros(0, dtype=np.int64)
        self._admitted = 0
        self._forgotten = 0

    def __len__(self) -> int:
        return len(self._entries)

    def apply(self, record: AnyRecord) -> None:
        """Take up a record; all but Admitted, Created, Concluded, Judged, Gained and Imported are passed over.

        An event's conclusion is that of its own processes, not of their children.
        """
        if isinstance(record, Admitted):
            self.admit(record.event)
        elif isinstance(record, Created):
            if record.parent:
                self._children.add(record.process)
        elif isinstance(record, Concluded):
            self._conclude(record)
        elif isinstance(record, Judged):
            entry = self._entry(record.event)
            if entry is not None and (record.verdict is not Verdict.UNDECIDED or not entry.verdict):
                entry.predicted, entry.outcome, entry.verdict = record.predicted, record.label, record.verdict.value
        elif isinstance(record, Gained):
            entry = self._entry(record.experience.event)
            if entry is not None:
                entry.experience = record.experience.id
                self._experienced[self._place_of(record.experience.event)] = 1
        elif isinstance(record, Imported):
            self._import(record)

    def search(self, query: Query, now_ns: int) -> tuple[Episode, ...]:
        """Concluded episodes of the query's entity and kind (any where empty), the likest first, without the query's own event.

        Likeness is 1 / (1 + distance of the features); 1 for all where the query names no remembered event, so that these
        come newest first. What lies after ``now_ns`` is not there yet.
        """
        self._write()
        wanted = _flags(self._concluded)
        own = self._place_of(query.event) if query.event in self._at else None
        if own is not None:
            wanted[own] = False
        for name, codes in ((query.entity, self._entities), (query.kind, self._kinds)):
            if name:
                wanted &= codes[: len(self._entries)] == hash(name)
        for index in range(len(self._entries) - 1, -1, -1):
            if self._entries[index].event.stamp.received_ns <= now_ns:
                break
            wanted[index] = False
        if own is None:
            newest = np.flatnonzero(wanted)[::-1][: max(0, query.limit)]
            return tuple(self._episode(int(index), 1.0) for index in newest)
        likest = self._nearest(self._rows[own].astype(np.float64), wanted, query.limit)
        return tuple(self._episode(index, round(1.0 / (1.0 + distance), _DIGITS)) for index, distance in likest)

    def nearest(self, features: Vector, k: int) -> tuple[int, ...]:
        """Ids of the k experiences whose events are likest to these features, shape (d,), the likest first."""
        self._write()
        found = self._nearest(features, _flags(self._experienced), k)
        return tuple(self._entries[index].experience for index, _ in found)

    def _nearest(self, features: Vector, wanted: npt.NDArray[np.bool_], limit: int) -> list[tuple[int, float]]:
        places = np.flatnonzero(wanted)
        if limit <= 0 or not len(places):
            return []
        count = len(self._entries)
        near = self._candidates(features, wanted, limit)
        if near is not None:
            places = near
        elif len(places) > limit:
            rough = self._norms[:count] - 2.0 * (self._rows[:count] @ features.astype(np.float32))
            rough = rough[places]
            # float32 errs by far less than this: whatever might belong to the first `limit` is measured again.
            slack = 1e-4 * (1.0 + float(np.abs(self._norms[:count]).max()))
            places = places[rough <= np.partition(rough, limit - 1)[limit - 1] + slack]
        apart = self._rows[places].astype(np.float64) - features.astype(np.float32)
        distances = np.round(np.sqrt(np.einsum("ij,ij->i", apart, apart)), _DIGITS)
        pairs = zip(places.tolist(), distances.tolist(), strict=True)
        return sorted(pairs, key=lambda pair: (pair[1], -self._entries[pair[0]].order, self._entries[pair[0]].event.id))[:limit]

    def _candidates(self, features: Vector, wanted: npt.NDArray[np.bool_], limit: int) -> npt.NDArray[np.intp] | None:
        """What the approximate index finds of what is wanted; None where there is no index, or it finds too few."""
        if self._near is None:
            return None
        found = np.sort(self._near.search(features.astype(np.float32), LOOKED_AT * limit))
        found = found[found < len(wanted)]
        found = found[wanted[found]]
        return found if len(found) >= limit else None

    def _keep_index(self, place: int) -> None:
        """Keep the index up with the rows, once there are too many for an exact search."""
        if self._near is None:
            if place < self._exact or not installed():
                return
            self._near = Approximate(self._rows.shape[1])
        for missing in range(len(self._near), place + 1):
            self._near.add(missing, self._rows[missing])

    def admit(self, event: Event) -> None:
        """Take up an admitted event, as ``apply`` does. Its features are written when they are needed, many at once."""
        if event.id in self._at:
            return
        if len(self._entries) >= self.limit:
            self._forget()
        self._waiting.append(event)
        self._at[event.id] = self._admitted
        self._admitted += 1
        self._entries.append(_Entry(event=event, order=self._admitted))
        self._experienced.append(0)
        self._concluded.append(0)
        if len(self._waiting) >= self._together:
            self._write()

    def hurry(self, hurries: bool) -> None:
        """While a journal is folded, the features of events that are forgotten again by its end are never written."""
        self._together = self.limit + 1 if hurries else TOGETHER
        if not hurries:
            self._write()

    def _write(self) -> None:
        """Write the features of those that were admitted since the last time."""
        waiting, self._waiting = self._waiting, []
        if not waiting:
            return
        features = self._encode_many(waiting).astype(np.float32)
        start = len(self._entries) - len(waiting)
        self._make_room(len(self._entries), features.shape[1])
        place = slice(start, len(self._entries))
        self._rows[place] = features
        self._norms[place] = np.einsum("ij,ij->i", features, features)
        # Python's own hashes: they are compared within this process alone, and never recorded.
        self._entities[place] = [hash(event.entity) for event in waiting]
        self._kinds[place] = [hash(event.kind) for event in waiting]
        self._keep_index(len(self._entries) - 1)

    def _import(self, record: Imported) -> None:
        """Another robot's event is remembered with what came of it; an event that is remembered already stays as it is."""
        if record.event.id in self._at:
            return
        self.admit(record.event)
        entry, gained = self._entries[-1], record.experience
        # Another robot's "box 1" is not this one's.
        whose = record.event.robot or gained.robot or record.origin
        entry.event = msgspec.structs.replace(record.event, entity=f"{whose}:{record.event.entity}")
        self._write()
        self._entities[len(self._entries) - 1] = hash(entry.event.entity)
        entry.treatment, entry.predicted, entry.outcome = gained.treatment, gained.predicted, gained.outcome
        entry.verdict, entry.experience = gained.verdict.value, gained.id
        self._experienced[-1] = self._concluded[-1] = 1

    def _conclude(self, record: Concluded) -> None:
        if record.process in self._children:
            self._children.discard(record.process)
            return
        entry = self._entry(record.event)
        if entry is None:
            return
        entry.treatment, entry.result = record.treatment, record.result
        entry.predicted = record.forecast.label if record.forecast is not None else ""
        self._concluded[self._place_of(record.event)] = 1

    def ran(self, burst: Ran, forecast: Forecast | None) -> None:
        """Take up what a process without a parent has concluded, as ``apply`` of its lines does."""
        at = self._at.get(burst.event)
        if at is not None:
            at -= self._forgotten
            entry = self._entries[at]
            entry.treatment, entry.result = burst.treatment, burst.result
            entry.predicted = forecast.label if forecast is not None else ""
            self._concluded[at] = 1

    def validated(self, judged: Judged, experience: Experience) -> None:
        """Take up a verdict and its experience, as ``apply`` of their lines does."""
        at = self._at.get(judged.event)
        if at is not None:
            at -= self._forgotten
            entry = self._entries[at]
            entry.predicted, entry.outcome, entry.verdict = judged.predicted, judged.label, judged.verdict
            entry.experience = experience.id
            self._experienced[at] = 1

    def _entry(self, event: str) -> _Entry | None:
        at = self._at.get(event)
        return None if at is None else self._entries[at - self._forgotten]

    def _place_of(self, event: str) -> int:
        return self._at[event] - self._forgotten

    def _episode(self, index: int, likeness: float) -> Episode:
        entry = self._entries[index]
        return Episode(
            event=entry.event.id,
            kind=entry.event.kind,
            entity=entry.event.entity,
            robot=entry.event.robot,
            at_ns=entry.event.stamp.source_ns,
            likeness=likeness,
            treatment=entry.treatment,
            says=_SAID.decode(entry.result).says if entry.result is not NOTHING else "",
            predicted=entry.predicted,
            outcome=entry.outcome,
            verdict=entry.verdict,
            experience=entry.experience,
            fields=entry.event.fields,
        )

    def _make_room(self, count: int, width: int) -> None:
        if count <= len(self._norms):
            return
        rows = max(_FIRST_ROWS, 2 * len(self._norms), count)
        before = len(self._norms)
        larger = np.zeros((rows, width), dtype=np.float32)
        if before:
            larger[:before] = self._rows
        self._rows = larger
        for name in _COLUMNS:
            setattr(self, name, np.concatenate([getattr(self, name), np.zeros(rows - before, dtype=getattr(self, name).dtype)]))

    def _forget(self) -> None:
        gone = max(1, len(self._entries) // 5)
        written = len(self._entries) - len(self._waiting)
        del self._waiting[: max(0, gone - written)]
        self._near = None  # places move: it is built anew from what is left
        for entry in self._entries[:gone]:
            del self._at[entry.event.id]
        del self._entries[:gone], self._experienced[:gone], self._concluded[:gone]
        self._forgotten += gone
        kept = max(0, written - gone)
        for name in ("_rows", *_COLUMNS):
            array = getattr(self, name)
            array[:kept] = array[gone : gone + kept].copy()


_SAID = msgspec.json.Decoder(_Said)


def _flags(values: bytearray) -> npt.NDArray[np.bool_]:
    """The values as flags of their own, which later changes don't touch."""
    return np.array(values, dtype=np.bool_)

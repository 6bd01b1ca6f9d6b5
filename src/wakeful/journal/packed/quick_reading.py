"""Readers by hand for what every automatic event wrote: the same facts as by the general coders, in half of the time.

What is seldom said of an event (an ordinal, a condition, a deadline, a true treatment) is left to the general reader, as is every
row whose facts have other fields. What is equal in thousands of events (a context, a mapping's names) is read once and shared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from wakeful.facts.choices import Basis, Choice
from wakeful.facts.events import Context, Event, Relation
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Judged, Trusted
from wakeful.facts.packs import Covered, Ran, Validated
from wakeful.facts.processes import State
from wakeful.facts.time import Stamp
from wakeful.facts.values import NOTHING, Field, Raw
from wakeful.journal.packed.known import as_known
from wakeful.journal.packed.words import BETWEEN, Words

Turn = Callable[[Any], Any]

#: So many contexts are shared at most.
_CONTEXTS = 1_024


def quick_readers(words: Words, schema: Mapping[str, tuple[str, ...]], general: Callable[[type], Turn]) -> dict[type, Turn]:
    """The readers by hand of Covered, Ran and Validated; none where a fact was written with other fields than they know.

    Args:
        words: the journal's.
        schema: the fields of each struct, in the order in which the row has them.
        general: the general reader of a class.
    """
    if not as_known(schema):
        return {}
    reading = _Reading(words, general)
    return {Covered: reading.covered, Ran: reading.ran, Validated: reading.validated}


class _Reading:
    """From plain data to facts, field by field."""

    def __init__(self, words: Words, general: Callable[[type], Turn]) -> None:
        self._text = words.text
        self._general = general(Covered)
        self._basis: Callable[[bytes], Basis] = general(Basis)
        self._trusted: Callable[[Any], Trusted] = general(Trusted)
        self._names: dict[bytes, list[str]] = {}
        self._contexts: dict[tuple[object, ...], Context] = {}
        self._relations = {str(each): each for each in Relation}
        self._verdicts = {str(each): each for each in Verdict}
        self._states = {str(each): each for each in State}

    def covered(self, plain: list[Any]) -> Covered:
        """Event, process, choice, deadline."""
        said, process, choice, deadline_ns = plain
        ordinal, condition, deadline_s, truth = said[6], said[11], said[13], said[16]
        if ordinal or condition is not None or deadline_s is not None or truth is not None:
            whole: Covered = self._general(plain)
            return whole
        basis, shares, prior, novelty, trust, rests_on, cell = choice
        return Covered(
            event=self._event(said),
            process=process,
            choice=Choice(
                basis=self._basis(basis),
                shares=tuple(map(float, shares)),
                prior=tuple(map(float, prior)),
                novelty=float(novelty),
                trust=float(trust),
                rests_on=tuple(rests_on),
                cell=cell,
            ),
            deadline_ns=deadline_ns,
        )

    def _event(self, said: list[Any]) -> Event:
        text = self._text
        identity, kind, entity, source, position, stamp, _, robot, relation, fields, context, _, criticality, _, says, seen, _ = (
            said
        )
        source_ns, clock, uncertainty_ns, received_ns = stamp
        return Event(  # at most 15 arguments: Python makes a dictionary of more, which takes five times as long
            id=text(identity),
            kind=text(kind),
            entity=text(entity),
            source=text(source),
            position=position,
            stamp=Stamp(source_ns=source_ns, clock=text(clock), uncertainty_ns=uncertainty_ns, received_ns=received_ns),
            robot=text(robot),
            relation=self._relations[relation],
            fields=self._fields(fields),
            context=self._context(*context),
            criticality=criticality,
            says=text(says),
            observations=seen,
        )

    def _context(self, task: bytes | str, zone: bytes | str, safety: bool, fields: list[Any] | None) -> Context:
        if fields is not None:
            return Context(task=self._text(task), zone=self._text(zone), safety=safety, fields=self._fields(fields))
        found = self._contexts.get((task, zone, safety))
        if found is None:
            if len(self._contexts) >= _CONTEXTS:
                self._contexts.clear()
            found = Context(task=self._text(task), zone=self._text(zone), safety=safety)
            self._contexts[task, zone, safety] = found
        return found

    def _fields(self, plain: list[Any] | None) -> dict[str, Field]:
        if plain is None:
            return {}
        head, *values = plain
        names = self._names.get(head) if isinstance(head, bytes) else None
        if names is None:
            names = head if isinstance(head, list) else self._text(head).split(BETWEEN)
            if isinstance(head, bytes):
                self._names[head] = names
        return dict(zip(names, [each if each.__class__ in _AS_THEY_ARE else self._field(each) for each in values], strict=True))

    def _field(self, value: Any) -> Field:
        return self._text(value) if isinstance(value, bytes | str) else tuple(float(each) for each in value)

    def ran(self, plain: list[Any]) -> Ran:
        """What a run came to."""
        process, event, before, steps_before, steps, treatment, mode, result, closes_ns = plain
        return Ran(
            process=process,
            event=self._text(event),
            before=self._states[before],
            steps_before=steps_before,
            steps=steps,
            treatment=self._text(treatment),
            mode=self._text(mode),  # type: ignore[arg-type]  # what was written is one
            result=NOTHING if result is None else Raw(result),
            closes_ns=closes_ns,
        )

    def validated(self, plain: list[Any]) -> Validated:
        """Outcome, verdict, experience, and trust where it moved."""
        outcome, judged, gained, trusted = plain
        return Validated(
            outcome=self._outcome(outcome),
            judged=self._judged(judged),
            experience=self._gained(gained),
            trusted=None if trusted is None else self._trusted(trusted),
        )

    def _outcome(self, plain: list[Any]) -> Outcome:
        text = self._text
        identity, topic, entity, label, at_ns, event, treatment, acted_on, origin, source = plain
        return Outcome(
            id=text(identity),
            topic=text(topic),
            entity=text(entity),
            label=text(label),
            at_ns=at_ns,
            event=text(event),
            treatment=text(treatment),
            acted_on=acted_on,
            origin=text(origin),  # type: ignore[arg-type]  # what was written is one
            source=text(source),
        )

    def _judged(self, plain: list[Any]) -> Judged:
        text = self._text
        process, event, predicted, label, verdict, outcome, why, lead_ns = plain
        return Judged(
            process=process,
            event=text(event),
            predicted=text(predicted),
            label=text(label),
            verdict=self._verdicts[verdict],
            outcome=text(outcome),
            why=text(why),
            lead_ns=lead_ns,
        )

    def _gained(self, plain: list[Any]) -> Experience:
        text = self._text
        identity, event, process, treatment, told, predicted, outcome, verdict, mode, robot, weight, acted_on = plain
        return Experience(
            id=identity,
            event=text(event),
            process=process,
            treatment=text(treatment),
            treatment_label=text(told),
            predicted=text(predicted),
            outcome=text(outcome),
            verdict=self._verdicts[verdict],
            mode=text(mode),
            robot=text(robot),
            weight=float(weight),
            acted_on=acted_on,
        )


_AS_THEY_ARE = frozenset({int, float, bool, type(None)})

"""Writers by hand for what every automatic event writes: the same plain data as by the general coders, in a third of the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from wakeful.facts.choices import Basis
from wakeful.facts.events import Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Judged, Trusted
from wakeful.facts.packs import Covered, Ran, Validated
from wakeful.facts.values import Field
from wakeful.journal.packed.known import as_known
from wakeful.journal.packed.words import BETWEEN, Words

Turn = Callable[[Any], Any]


def quick_writers(words: Words, schema: Mapping[str, tuple[str, ...]], general: Callable[[type], Turn]) -> dict[type, Turn]:
    """The writers by hand of Covered, Ran and Validated; none where a fact has other fields than they know.

    Args:
        words: the journal's.
        schema: the fields of each struct, in their order.
        general: the general writer of a class.
    """
    if not as_known(schema):
        return {}
    writing = _Writing(words, general)
    return {Covered: writing.covered, Ran: writing.ran, Validated: writing.validated}


class _Writing:
    """From facts to plain data, field by field."""

    def __init__(self, words: Words, general: Callable[[type], Turn]) -> None:
        self._words = words
        self._identity = words.identity
        self._basis: Callable[[Basis], bytes] = general(Basis)
        self._trusted = general(Trusted)

    def covered(self, burst: Covered) -> tuple[Any, ...]:
        """Event, process, choice, deadline."""
        choice = burst.choice
        return (
            self._event(burst.event),
            burst.process,
            (self._basis(choice.basis), choice.shares, choice.prior, choice.novelty, choice.trust, choice.rests_on, choice.cell),
            burst.deadline_ns,
        )

    def _event(self, event: Event) -> tuple[Any, ...]:
        words = self._words
        stamp, context, condition, truth = event.stamp, event.context, event.condition, event.truth_treatment
        return (
            self._identity(event.id),
            words[event.kind],
            event.entity,
            words[event.source],
            event.position,
            (stamp.source_ns, words[stamp.clock], stamp.uncertainty_ns, stamp.received_ns),
            event.ordinal,
            words[event.robot],
            event.relation,
            self._fields(event.fields),
            (words[context.task], words[context.zone], context.safety, self._fields(context.fields)),
            None if condition is None else (condition.key, condition.phase),
            event.criticality,
            event.deadline_s,
            event.says,
            event.observations,
            None if truth is None else words[truth],
        )

    def _fields(self, values: Mapping[str, Field]) -> Any:
        if not values:
            return None
        words = self._words
        names = BETWEEN.join(values)
        head: Any = words[names] if names.count(BETWEEN) == len(values) - 1 else list(values)
        return (head, *[words[each] if each.__class__ is str else each for each in values.values()])

    def ran(self, burst: Ran) -> tuple[Any, ...]:
        """What a run came to."""
        result = bytes(burst.result)
        return (
            burst.process,
            self._identity(burst.event),
            burst.before,
            burst.steps_before,
            burst.steps,
            self._words[burst.treatment],
            self._words[burst.mode],
            None if result == b"null" else result,
            burst.closes_ns,
        )

    def validated(self, burst: Validated) -> tuple[Any, ...]:
        """Outcome, verdict, experience, and trust where it moved."""
        trusted = burst.trusted
        return (
            self._outcome(burst.outcome),
            self._judged(burst.judged),
            self._gained(burst.experience),
            None if trusted is None else self._trusted(trusted),
        )

    def _outcome(self, outcome: Outcome) -> tuple[Any, ...]:
        words, identity = self._words, self._identity
        return (
            identity(outcome.id),
            words[outcome.topic],
            outcome.entity,
            words[outcome.label],
            outcome.at_ns,
            identity(outcome.event),
            words[outcome.treatment],
            outcome.acted_on,
            words[outcome.origin],
            words[outcome.source],
        )

    def _judged(self, judged: Judged) -> tuple[Any, ...]:
        words, identity = self._words, self._identity
        return (
            judged.process,
            identity(judged.event),
            words[judged.predicted],
            words[judged.label],
            judged.verdict,
            identity(judged.outcome),
            judged.why,
            judged.lead_ns,
        )

    def _gained(self, gained: Experience) -> tuple[Any, ...]:
        words, identity = self._words, self._identity
        return (
            gained.id,
            identity(gained.event),
            gained.process,
            words[gained.treatment],
            words[gained.treatment_label],
            words[gained.predicted],
            identity(gained.outcome),
            gained.verdict,
            words[gained.mode],
            words[gained.robot],
            gained.weight,
            gained.acted_on,
        )

"""Writers by hand for what every automatic event writes: the same plain data as by the general coders, in a third of the time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from wakeful.facts.choices import Basis, Choice
from wakeful.facts.events import Condition, Context, Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Judged, Trusted
from wakeful.facts.packs import Covered, Ran, Validated
from wakeful.facts.time import Stamp
from wakeful.facts.values import Field
from wakeful.journal.packed.words import BETWEEN, Words

Turn = Callable[[Any], Any]

#: The fields that the writers know, in their order. Where a fact has others, the general coders do it.
_KNOWN: dict[type, str] = {
    Stamp: "source_ns clock uncertainty_ns received_ns",
    Context: "task zone safety fields",
    Condition: "key phase",
    Event: "id kind entity source position stamp ordinal robot relation fields context condition criticality deadline_s says "
    "observations truth_treatment",
    Choice: "basis shares prior novelty trust rests_on cell",
    Covered: "event process choice deadline_ns",
    Ran: "process event before steps_before steps treatment mode result closes_ns",
    Outcome: "id topic entity label at_ns event treatment acted_on origin source",
    Judged: "process event predicted label verdict outcome why lead_ns",
    Experience: "id event process treatment treatment_label predicted outcome verdict mode robot weight acted_on",
    Validated: "outcome judged experience trusted",
}


def quick_writers(words: Words, schema: Mapping[str, tuple[str, ...]], general: Callable[[type], Turn]) -> dict[type, Turn]:
    """The writers by hand of Covered, Ran and Validated; none where a fact has other fields than they know.

    Args:
        words: the journal's.
        schema: the fields of each struct, in their order.
        general: the general writer of a class.
    """
    if any(schema[cls.__name__] != tuple(known.split()) for cls, known in _KNOWN.items()):
        return {}
    identity = words.identity
    basis: Callable[[Basis], bytes] = general(Basis)
    trusted = general(Trusted)

    def fields(values: Mapping[str, Field]) -> Any:
        if not values:
            return None
        names = BETWEEN.join(values)
        head: Any = words[names] if names.count(BETWEEN) == len(values) - 1 else list(values)
        return (head, *[words[each] if each.__class__ is str else each for each in values.values()])

    def covered(burst: Covered) -> tuple[Any, ...]:
        event, choice = burst.event, burst.choice
        stamp, context, condition, truth = event.stamp, event.context, event.condition, event.truth_treatment
        return (
            (
                identity(event.id),
                words[event.kind],
                event.entity,
                words[event.source],
                event.position,
                (stamp.source_ns, words[stamp.clock], stamp.uncertainty_ns, stamp.received_ns),
                event.ordinal,
                words[event.robot],
                event.relation,
                fields(event.fields),
                (words[context.task], words[context.zone], context.safety, fields(context.fields)),
                None if condition is None else (condition.key, condition.phase),
                event.criticality,
                event.deadline_s,
                event.says,
                event.observations,
                None if truth is None else words[truth],
            ),
            burst.process,
            (basis(choice.basis), choice.shares, choice.prior, choice.novelty, choice.trust, choice.rests_on, choice.cell),
            burst.deadline_ns,
        )

    def ran(burst: Ran) -> tuple[Any, ...]:
        result = bytes(burst.result)
        return (
            burst.process,
            identity(burst.event),
            burst.before,
            burst.steps_before,
            burst.steps,
            words[burst.treatment],
            words[burst.mode],
            None if result == b"null" else result,
            burst.closes_ns,
        )

    def validated(burst: Validated) -> tuple[Any, ...]:
        outcome, judged, gained = burst.outcome, burst.judged, burst.experience
        return (
            (
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
            ),
            (
                judged.process,
                identity(judged.event),
                words[judged.predicted],
                words[judged.label],
                judged.verdict,
                identity(judged.outcome),
                judged.why,
                judged.lead_ns,
            ),
            (
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
            ),
            None if burst.trusted is None else trusted(burst.trusted),
        )

    return {Covered: covered, Ran: ran, Validated: validated}

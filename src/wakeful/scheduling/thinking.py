"""A process's coroutine: deliberate on what treatment where the mode says so, then treat."""

from __future__ import annotations

from collections.abc import Callable

import msgspec

from wakeful.contracts.treatment import Treatment
from wakeful.facts.asking import Episode, Query, Question, Reply
from wakeful.facts.decisions import Decision
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.results import Result
from wakeful.facts.values import Field
from wakeful.scheduling.mind import KernelMind

#: What the kernel's own question is about; its answer may change the process's treatment.
WHICH_TREATMENT = "treatment"

#: What stands in for a treatment that is not there any more, where the domain allows it.
GENERAL = ("analogy", "description")

#: How many validated episodes are laid before the reasoner.
EPISODES_SHOWN = 5


async def think(
    event: Event,
    mind: KernelMind,
    treatment: Callable[[str], Treatment],
    options: tuple[str, ...],
    chosen: bool,
) -> Result:
    """Treat one event.

    Args:
        event: what to think about.
        mind: what may be awaited.
        treatment: finds a treatment by name.
        options: the treatments among which deliberation may choose.
        chosen: the treatment is settled (a child's, or an automatic or fallback one): no question is put.
    """
    name = mind.treatment
    if not chosen and mind.mode == "delib":
        episodes = await mind.recall(Query(event=event.id, kind=event.kind, entity=event.entity, limit=EPISODES_SHOWN))
        reply = await mind.deliberate(which_treatment(event, episodes, mind.domain, options))
        mind.advise(reply)
        name = reply.choice
    return await treatment(name).treat(event, mind)


def which_treatment(event: Event, episodes: tuple[Episode, ...], domain: DomainSpec, options: tuple[str, ...]) -> Question:
    """The question of what treatment an event needs, and what the world will show. Everything in it is recorded data."""
    return Question(
        about=WHICH_TREATMENT,
        event=event.id,
        asks="Which treatment does this event need, and which outcome will follow within the window?",
        options=options,
        labels=domain.outcome.labels,
        facts=facts_of(event),
        history=tuple(_sentence(each) for each in episodes if each.outcome),
    )


def facts_of(event: Event) -> dict[str, str]:
    """An event's fields as JSON scalars, with kind, relation, entity, task, zone and safety beside them."""
    named: dict[str, Field] = {
        **event.context.fields,
        **event.fields,
        "kind": event.kind,
        "relation": event.relation.value,
        "entity": event.entity,
        "task": event.context.task,
        "zone": event.context.zone,
        "safety": event.context.safety,
        "says": event.says,
    }
    return {name: value if isinstance(value, str) else msgspec.json.encode(value).decode() for name, value in named.items()}


def _sentence(episode: Episode) -> str:
    ended = f"{episode.outcome} ({episode.verdict})" if episode.verdict else episode.outcome
    return (
        f"{episode.kind} at {episode.entity}, likeness {episode.likeness:.2f}: treated by {episode.treatment}, ended in {ended}"
    )


def revised(decision: Decision, reply: Reply, prior: dict[str, float]) -> Decision:
    """The decision after deliberation answered: its treatment, with the reasoner's confidence and reasons, and what to expect."""
    return msgspec.structs.replace(
        decision,
        treatment=reply.choice,
        prior=prior,
        confidence=round(reply.confidence, 6),
        reasons=(*decision.reasons, *(f"{reply.reasoner or 'reasoner'}: {reason}" for reason in reply.because)),
    )


def provisional(decision: Decision, why: str, instead: str = "") -> Decision:
    """The decision after a treatment failed: the same treatment, by general means, until something better is known.

    ``instead`` stands in for a treatment that is not there any more.
    """
    reasons = (*decision.reasons, f"in fallback since {why}")
    return msgspec.structs.replace(decision, treatment=instead or decision.treatment, mode="fallback", reasons=reasons)

"""The deliberative form of a treatment: its own typed question to the reasoner, and the answer checked against the domain.

What fails the check is recorded and left: the treatment goes on by its own method. The reasoner's words are data.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Generic, TypeVar

import msgspec

from wakeful.contracts.treatment import Mind, Refusal
from wakeful.facts.asking import Episode, Question
from wakeful.facts.events import Event
from wakeful.facts.results import Consulted
from wakeful.facts.values import Fact, Raw
from wakeful.treatments.hazards import circumstances
from wakeful.treatments.wording import brief, percent

A = TypeVar("A", bound=Fact)

#: What the reasoner chooses between beside the answer itself.
ANSWERED, NO_ANSWER = "answered", "no answer"

#: So many of the recalled cases are laid before it.
SHOWN = 6


class Consultation(msgspec.Struct, Generic[A]):
    """What came of a question. ``answer`` is None where it was not asked, not given, or failed the check."""

    answer: A | None = None
    consulted: Consulted | None = None

    @property
    def basis(self) -> tuple[str, ...]:
        """How ``rests_on`` names it."""
        if self.consulted is None:
            return ()
        kind = "answer" if self.consulted.used else "no usable answer"
        return (f"reasoner's {kind} on {self.consulted.about}: {self.consulted.said or self.consulted.why}",)


async def consult(
    event: Event,
    mind: Mind,
    about: str,
    asks: str,
    form: type[A],
    check: Callable[[A], str],
    past: Iterable[Episode] = (),
    choices: Iterable[str] = (),
) -> Consultation[A]:
    """Put a treatment's own question to the reasoner, where the mind consults one.

    Args:
        event: what is treated; its fields are the question's facts.
        mind: of the process; outside delib mode, or where its settings say so, nothing is asked.
        about: the treatment's name.
        asks: the question in one sentence.
        form: the answer's type; its JSON schema goes with the question.
        check: what is wrong with an answer by the domain; empty where nothing is.
        past: recalled cases, named by their event ids.
        choices: names that the answer may use, such as faults or nodes, for the reasoner to see.

    Returns:
        The answer if it passed the check, and in any case what is to be recorded.
    """
    if not mind.consults:
        return Consultation()
    facts = {
        name: value if isinstance(value, str) else msgspec.json.encode(value).decode() for name, value in _facts(event).items()
    }
    named = list(choices)
    if named:
        facts["may_name"] = msgspec.json.encode(named).decode()
    question = Question(
        about=about,
        event=event.id,
        asks=asks,
        options=(ANSWERED, NO_ANSWER),
        facts=facts,
        history=tuple(_sentence(case) for case in list(past)[:SHOWN]),
        schema=Raw(msgspec.json.encode(msgspec.json.schema(form))),
    )
    try:
        reply = await mind.deliberate(question)
    except Refusal as refusal:
        return Consultation(consulted=Consulted(about=about, used=False, why=brief(str(refusal), 160)))
    who, because = reply.reasoner or "reasoner", "; ".join(brief(reason, 120) for reason in reply.because[:2])
    if reply.choice != ANSWERED:
        return Consultation(consulted=Consulted(about=about, who=who, used=False, why=because or "it has no answer"))
    try:
        answer = msgspec.json.decode(reply.answer, type=form)
    except msgspec.DecodeError as error:
        return Consultation(consulted=Consulted(about=about, who=who, used=False, why=f"malformed: {error}"))
    said = brief(", ".join(f"{name} {value}" for name, value in msgspec.to_builtins(answer).items()), 200)
    objection = check(answer)
    if objection:
        return Consultation(consulted=Consulted(about=about, who=who, said=said, used=False, why=f"refused: {objection}"))
    why = f"checked against the domain; {because}" if because else "checked against the domain"
    sure = f"{percent(reply.confidence)} sure"
    return Consultation(answer, Consulted(about=about, who=who, said=f"{said} ({sure})", used=True, why=why))


def _facts(event: Event) -> dict[str, object]:
    return {**circumstances(event), "says": brief(event.says, 400)}


def _sentence(case: Episode) -> str:
    ended = f"{case.outcome} ({case.verdict})" if case.verdict else case.outcome or "not known yet"
    return f"case {case.event}: {case.kind} at {brief(case.entity)}, treated by {case.treatment}, ended in {ended}"

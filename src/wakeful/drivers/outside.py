"""Making the calls that the kernel asked for: a reasoner's answer, a user's function."""

from __future__ import annotations

import asyncio
import inspect

import msgspec

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation.replies import Inadmissible, check
from wakeful.facts.asking import Question, Reply
from wakeful.facts.inputs import Answer, Call

#: A reply is journaled whole: a longer one is refused.
LARGEST_REPLY_BYTES = 64 * 1024


async def make(call: Call, reasoner: Reasoner) -> Answer:
    """Make one call and wait for its answer. Whatever goes wrong is the answer's ``error``; only cancellation is raised."""
    try:
        if call.function is not None:
            told = call.function()
            if inspect.isawaitable(told):
                told = await told
            return Answer(process=call.process, seq=call.seq, value=msgspec.Raw(msgspec.json.encode(told)), calls=0)
        if call.question is not None and not call.role:
            reply = await reasoner.answer(call.question)
            value = _admissible(reply, call.question)
            return Answer(process=call.process, seq=call.seq, value=value, cost_usd=reply.cost_usd, calls=reply.calls)
    except ReasonerError as error:
        return Answer(
            process=call.process,
            seq=call.seq,
            error=str(error)[:500] or "refused",
            cost_usd=error.cost_usd,
            calls=error.calls,
        )
    except asyncio.CancelledError:
        raise
    except Exception as error:  # a user's function may raise anything; the treatment hears of it as a Refusal
        calls = int(call.question is not None)  # a reasoner of others that has a defect may have been paid all the same
        return Answer(process=call.process, seq=call.seq, error=f"{type(error).__name__}: {error}"[:500], calls=calls)
    return Answer(process=call.process, seq=call.seq, error="nobody is there to answer")


def _admissible(reply: Reply, question: Question) -> msgspec.Raw:
    """The reply as it is recorded. wakeful's own reasoners check what a model says; this is for those of others.

    Raises:
        Inadmissible: it is no reply, says what the question does not admit, or is too long.
    """
    if not isinstance(reply, Reply):
        raise Inadmissible(f"the reasoner returned {type(reply).__name__}, not a Reply", calls=1)
    try:
        text = msgspec.json.encode(check(reply, question))
    except ReasonerError as error:
        error.calls, error.cost_usd = reply.calls, reply.cost_usd
        raise
    if len(text) > LARGEST_REPLY_BYTES:
        what = f"the reply has {len(text)} bytes, at most {LARGEST_REPLY_BYTES} are taken"
        raise Inadmissible(what, calls=reply.calls, cost_usd=reply.cost_usd)
    return msgspec.Raw(text)

"""Making the calls that the kernel asked for: a reasoner's answer, a user's function."""

from __future__ import annotations

import asyncio
import inspect

import msgspec

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.facts.inputs import Answer, Call


async def make(call: Call, reasoner: Reasoner) -> Answer:
    """Make one call and wait for its answer. Whatever goes wrong is the answer's ``error``; only cancellation is raised."""
    try:
        if call.function is not None:
            value = call.function()
            if inspect.isawaitable(value):
                value = await value
            return Answer(process=call.process, seq=call.seq, value=msgspec.Raw(msgspec.json.encode(value)), calls=0)
        if call.question is not None and not call.role:
            reply = await reasoner.answer(call.question)
            return Answer(
                process=call.process,
                seq=call.seq,
                value=msgspec.Raw(msgspec.json.encode(reply)),
                cost_usd=reply.cost_usd,
                calls=reply.calls,
            )
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
        return Answer(process=call.process, seq=call.seq, error=f"{type(error).__name__}: {error}"[:500])
    return Answer(process=call.process, seq=call.seq, error="nobody is there to answer")

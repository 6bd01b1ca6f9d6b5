"""``@wakeful.treatment``: a treatment made of one coroutine function."""

from __future__ import annotations

import re
from collections.abc import Awaitable, Callable
from inspect import getdoc, iscoroutinefunction, signature
from typing import get_type_hints

from wakeful.contracts.treatment import Mind
from wakeful.facts.events import Event
from wakeful.facts.results import Result

_NAME = re.compile(r"[a-z][a-z0-9_]*")

Thinks = Callable[[Event, Mind], Awaitable[Result]]


class TreatmentError(Exception):
    """A treatment that cannot be made or found. The message says what is wrong, where, and what to do."""


class FunctionTreatment:
    """A Treatment whose thinking is one coroutine function. Made by ``treatment``; it can also be called as the function."""

    def __init__(self, function: Thinks, name: str, result: type[Result], says: str, version: int) -> None:
        self.name = name
        self.version = version
        self.says = says
        self.result: type[Result] = result
        self.__wrapped__ = function
        self.__doc__ = getdoc(function)

    def __repr__(self) -> str:
        return f"<treatment {self.name} version {self.version}>"

    async def treat(self, event: Event, mind: Mind) -> Result:
        """Think about one event."""
        return await self.__wrapped__(event, mind)


def treatment(
    name: str | None = None, *, result: type[Result] | None = None, says: str = "", version: int = 1
) -> Callable[[Thinks], FunctionTreatment]:
    """Make a treatment of ``async def f(event, mind) -> SomeResult``.

    Args:
        name: how selection and the journal call it: small letters, digits and ``_``; the function's own name if not given.
        result: the Result subclass that it returns; read from the annotation if not given.
        says: one sentence for people and reasoners; the first line of the docstring if not given.
        version: raise it when the thinking changes, so that old results can be told from new ones.

    Returns:
        A decorator that makes the function a Treatment.

    Raises:
        TreatmentError: not a coroutine function of two arguments, a bad name, no Result type, or nothing that says what it does.

    >>> class Greeting(Result, frozen=True, kw_only=True, tag="greeting"):
    ...     whom: str
    >>> @treatment(says="Greets whatever is new.")
    ... async def greeting(event: Event, mind: Mind) -> Greeting:
    ...     await mind.work()
    ...     return Greeting(says=f"hello, {event.entity}", confidence=1.0, rests_on=(event.id,), whom=event.entity)
    >>> greeting
    <treatment greeting version 1>
    """

    def make(function: Thinks) -> FunctionTreatment:
        own = getattr(function, "__name__", "")
        called = own if name is None else name
        if not iscoroutinefunction(function) or len(signature(function).parameters) != 2:
            raise TreatmentError(f"treatment {called or function!r}: write it as `async def {called or 'name'}(event, mind)`")
        if not _NAME.fullmatch(called):
            raise TreatmentError(f"treatment {called!r}: a name is small letters, digits and _, and begins with a letter")
        returned = result or _returned(function)
        if not (isinstance(returned, type) and issubclass(returned, Result)):
            raise TreatmentError(f"treatment {called}: give result=…, a subclass of wakeful.facts.results.Result")
        if version < 1:
            raise TreatmentError(f"treatment {called}: version {version} must be 1 or more")
        line = says or (getdoc(function) or "").partition("\n")[0]
        if not line:
            raise TreatmentError(f"treatment {called}: give says=… or a docstring; a reasoner chooses by that sentence")
        return FunctionTreatment(function, called, returned, line, version)

    return make


def _returned(function: Thinks) -> object:
    try:
        return get_type_hints(function).get("return")
    except NameError:
        # the annotation names something that exists only for type checkers
        return None

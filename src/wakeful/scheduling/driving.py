"""Driving a process's coroutine: starting it, answering it, and rebuilding it over its recorded answers."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from inspect import iscoroutine

import msgspec

from wakeful.contracts.treatment import Refusal, Treatment
from wakeful.facts.asking import Episode, Kind, Reply
from wakeful.facts.choices import Choice
from wakeful.facts.crashes import MARKED, Page, mark
from wakeful.facts.decisions import Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.evidence import Evidence
from wakeful.facts.lines import Answered
from wakeful.facts.results import Result, Unresolved
from wakeful.scheduling.mind import KernelMind
from wakeful.scheduling.process import Process
from wakeful.scheduling.thinking import GENERAL, WHICH_TREATMENT, think
from wakeful.scheduling.wants import Want, Work

#: What an Answered says in ``error`` when the request's limit passed.
EXPIRED = "expired"

_EPISODES = msgspec.json.Decoder(tuple[Episode, ...])
_EVIDENCE = msgspec.json.Decoder(tuple[Evidence, ...])
_REPLY = msgspec.json.Decoder(Reply)
_TYPED = msgspec.json.Decoder(dict[str, msgspec.Raw])

Step = Work | Want | Result


class Mismatch(Exception):
    """The code no longer makes the requests that were recorded."""


class Failure(Exception):
    """The treatment raised, or returned no Result; ``str`` says what, for the record."""


class Coroutines:
    """Starts, answers and rebuilds coroutines. Holds no state of its own beside what it was made with, and the ``page`` on which
    it says whose code is running.

    Args:
        treatment: finds a treatment by name; raises KeyError where there is none.
        spec: the domain's data, for every mind.
        options: the treatments among which deliberation may choose.
        consults: whether treatments may put questions of their own to the reasoner.
    """

    def __init__(
        self, treatment: Callable[[str], Treatment], spec: DomainSpec, options: tuple[str, ...], consults: bool = False
    ) -> None:
        self._treatment = treatment
        self._spec = spec
        self._options = options
        self._consults = consults
        self.page: Page = bytearray(MARKED)

    def rebuild(self, process: Process, steps: int) -> Step:
        """The coroutine's want after all its recorded answers and ``steps`` steps of work, counted over all attempts.

        A process that has not run yet is started by the same way. Nothing outside is run again.

        Raises:
            Mismatch: the code asks for something else than was recorded.
            Failure: the treatment raised.
        """
        # An automatic decision that stands as it was made is taken as its numbers: its words are for who reads them.
        first = process.choice if process.first is None and process.choice is not None else process.first_of_attempt
        if first is None:
            raise Mismatch("the process has no decision")
        mode: Mode = "auto" if isinstance(first, Choice) else first.mode
        mind = process.mind = KernelMind(mode, first, self._spec, process.arrived_ns, self._consults)
        if not isinstance(first, Choice):
            mind.current = process.decision
        chosen = process.parent != 0
        process.coroutine = think(process.event, mind, self._treatment, self._options, chosen)
        budget = steps - process.base_steps
        recorded = [asked for asked in process.asked if asked.seq > process.base_seq]
        want = self.send(process, None)
        for asked in recorded:
            while isinstance(want, Work) and budget >= want.left:
                budget -= want.left
                want = self.send(process, None)
            if not isinstance(want, Want) or (want.kind, want.key) != (asked.kind, asked.key):
                raise Mismatch(
                    f"request {asked.seq} was recorded as {asked.kind} {asked.key!r}; the code now asks for {_named(want)}"
                )
            answer = process.answers.get(asked.seq)
            if answer is None:
                return want
            # What treatments there are may have changed since the kernel asked which one to take: that answer stands.
            own = asked.kind is Kind.DELIBERATE and asked.key == WHICH_TREATMENT
            if asked.args and not own and want.digest() != asked.args:
                raise Mismatch(f"request {asked.seq} ({asked.kind} {asked.key!r}) now has other arguments than were recorded")
            want = self.answer(process, want, answer)
        while isinstance(want, Work) and budget > 0 and budget >= want.left:
            budget -= want.left
            want = self.send(process, None)
        if isinstance(want, Work):
            want.left -= budget
        return want

    def begin(self, process: Process, choice: Choice) -> bool:
        """Make the coroutine of an automatic process that has not run yet; False where its treatment is not to be had."""
        try:
            treatment = self._treatment(choice.basis.treatment)
            mind = KernelMind("auto", choice, self._spec, process.arrived_ns, self._consults)
            coroutine = treatment.treat(process.event, mind)
        except (
            Exception
        ):  # whatever the registry, or a treatment that is no coroutine function, raises: found again by ``rebuild``
            return False
        if not iscoroutine(coroutine):
            return False
        process.mind, process.coroutine = mind, coroutine
        return True

    def send(self, process: Process, value: object) -> Step:
        """Resume the coroutine with ``value``, up to its next want or its result.

        Raises:
            Failure: the treatment raised, or returned something that is no Result.
        """
        return self._run(process, _warm(process).send, value)

    def answer(self, process: Process, want: Want, answered: Answered) -> Step:
        """Resume the coroutine with a recorded answer to ``want``. Raises Failure as ``send`` does."""
        coroutine = _warm(process)
        if process.mind is not None:
            process.mind.heard_ns = process.answered_ns[answered.seq]
        if answered.error and want.kind in (Kind.DELIBERATE, Kind.CALL, Kind.TREAT):
            return self._run(process, coroutine.throw, Refusal(answered.error))
        try:
            value = self._value(want, answered)
        except Exception as error:  # decoding fails as the user's types say; a treatment that is gone, as its registry says
            raise Mismatch(f"the answer to request {answered.seq} ({want.kind} {want.key!r}) cannot be read: {error}") from error
        return self._run(process, coroutine.send, value)

    def _value(self, want: Want, answered: Answered) -> object:
        text = answered.value
        match want.kind:
            case Kind.EVIDENCE:
                return _EVIDENCE.decode(text) if not answered.error else ()
            case Kind.RECALL:
                return _EPISODES.decode(text)
            case Kind.DELIBERATE:
                return _REPLY.decode(text)
            case Kind.ASK:
                return None if answered.error else _REPLY.decode(text)
            case Kind.TREAT:
                return self.result(want.key, text)
            case Kind.CALL:
                return msgspec.json.decode(text)
            case _:
                return None

    def readable(self, want: Want, answered: Answered) -> bool:
        """Whether today's code can read a recorded answer to that request."""
        try:
            self._value(want, answered)
        except Exception:  # as in ``answer``: whatever decoding or the registry raises
            return bool(answered.error)
        return True

    def knows(self, treatment: str) -> bool:
        """Whether there is a treatment of that name."""
        try:
            self._treatment(treatment)
        except Exception:  # whatever the registry raises where there is none
            return False
        return True

    def instead_of(self, treatment: str) -> str:
        """What stands in for a treatment that is not there any more: a general one; empty where it is there, or nothing is."""
        if self.knows(treatment):
            return ""
        known = [name for name in self._options if self.knows(name)]
        return next((name for name in GENERAL if name in known), known[0] if known else "")

    def result(self, treatment: str, text: msgspec.Raw) -> Result:
        """A recorded result in the treatment's own type, or as Unresolved."""
        if bytes(_TYPED.decode(text)["type"]) == b'"unresolved"':
            return msgspec.json.decode(text, type=Unresolved)
        return msgspec.json.decode(text, type=self._treatment(treatment).result)

    def _run(
        self, process: Process, resume: Callable[[object], object] | Callable[[BaseException], object], value: object
    ) -> Step:
        mark(self.page, process.event.id)
        try:
            want = resume(value)  # type: ignore[arg-type]  # send takes any value, throw an exception: the caller pairs them
        except StopIteration as stop:
            if not isinstance(stop.value, Result):
                raise Failure(f"it returned {type(stop.value).__name__}, not a Result") from None
            return stop.value
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # a user's code may raise anything, SystemExit too; the event keeps its process
            raise Failure(f"{type(error).__name__}: {error}"[:500]) from error
        finally:
            self.page[0] = 0
        if not isinstance(want, Work | Want):
            raise Failure(f"it awaited {type(want).__name__}, which is not the mind's")
        return want


def ended(value: object) -> Callable[[], Step]:
    """What a coroutine that has returned ``value`` has come to, as ``Coroutines`` would give it: a result, or a Failure."""

    def found() -> Step:
        if not isinstance(value, Result):
            raise Failure(f"it returned {type(value).__name__}, not a Result")
        return value

    return found


def failed(error: BaseException) -> Callable[[], Step]:
    """The same for one that has raised."""
    why = f"{type(error).__name__}: {error}"[:500]

    def found() -> Step:
        raise Failure(why)

    return found


def wanted(want: object) -> Callable[[], Step]:
    """The same for one that wants something."""

    def found() -> Step:
        if not isinstance(want, Work | Want):
            raise Failure(f"it awaited {type(want).__name__}, which is not the mind's")
        return want

    return found


def objection(result: Result) -> str:
    """What is wrong with a result, whatever its treatment; empty where nothing is.

    >>> objection(Unresolved(says="x", confidence=float("nan"), failure="y"))
    'its result has confidence nan; it must lie in [0, 1]'
    """
    if not 0.0 <= result.confidence <= 1.0:
        return f"its result has confidence {result.confidence}; it must lie in [0, 1]"
    forecast = result.forecast
    if forecast is not None:
        shares = forecast.probabilities.values()
        if not 0.0 <= forecast.probability <= 1.0 or (shares and not (min(shares) >= 0.0 and max(shares) <= 1.0)):
            return f"its forecast has a probability outside [0, 1]: {(forecast.probability, *shares)}"
    return ""


def _warm(process: Process) -> Coroutine[object, object, Result]:
    if process.coroutine is None:
        raise Failure("its coroutine is cold; it must be rebuilt first")
    return process.coroutine


def _named(want: Step) -> str:
    if isinstance(want, Want):
        return f"{want.kind} {want.key!r}"
    return "work" if isinstance(want, Work) else "nothing more"

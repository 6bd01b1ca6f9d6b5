"""The contract that every treatment keeps, its author's as well as the built-in ones."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import msgspec

from wakeful.contracts.treatment import Refusal, Treatment
from wakeful.facts.decisions import Mode
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Event
from wakeful.facts.results import Forecast, Result
from wakeful.facts.time import to_s
from wakeful.testing.broken import ContractBroken, require
from wakeful.testing.scripted_mind import Evicted, Exchange, Script, ScriptedMind

MODES: tuple[Mode, ...] = ("auto", "delib", "fallback")


def check_treatment(
    treatment: Treatment,
    event: Event,
    domain: DomainSpec,
    script: Script | None = None,
    modes: Sequence[Mode] = MODES,
    auto_steps: int | None = None,
) -> dict[Mode, Result]:
    """Check a treatment against its contract on one event, in every mode.

    In each mode it is run to its end, run again from the event's JSON, run again over its recorded answers, evicted at every
    await, and run with a mind that knows nothing and answers nobody. Its result must be of its declared type, survive JSON,
    explain itself, forecast only what the domain knows, and be there by the event's deadline.

    Args:
        treatment: what is checked.
        event: what it thinks about; it must come back unchanged.
        domain: the domain's data.
        script: what is remembered and answered; nothing if not given.
        modes: the modes to check.
        auto_steps: the most steps of work it may spend in auto mode; not checked if not given.

    Returns:
        The result of each mode, for further checks of one's own.

    Raises:
        ContractBroken: it does not keep its contract; the message says where.
        Exception: whatever the treatment raises. Only Refusal, in delib mode, with nobody to answer, is within the contract.
    """
    _check_kind(treatment)
    given = Script() if script is None else script
    results: dict[Mode, Result] = {}
    for mode in modes:
        where = f"{treatment.name} in {mode} mode on {event.kind} event {event.id}"
        before = msgspec.json.encode(event)
        mind = ScriptedMind(domain, mode, given)
        result = mind.run(treatment, event)
        require(msgspec.json.encode(event) == before, f"{where}: it changed the event")
        _check_result(treatment, result, domain, where)
        _check_repeatable(treatment, event, domain, given, mode, mind.exchanges, result, where)
        _check_in_time(event, given, mind, where)
        if mode == "auto" and auto_steps is not None:
            steps = sum(int(each.request.key) for each in mind.exchanges if each.request.kind == "work")
            require(steps <= auto_steps, f"{where}: it spent {steps} steps, {auto_steps} are allowed")
        _check_alone(treatment, event, domain, given, mode, where)
        results[mode] = result
    return results


def _check_kind(treatment: Treatment) -> None:
    require(bool(treatment.name) and treatment.name.isidentifier(), f"name {treatment.name!r}: letters, digits and _")
    require(isinstance(treatment.version, int) and treatment.version >= 1, f"{treatment.name}: version must be 1 or more")
    require(bool(treatment.says.strip()), f"{treatment.name}: says must tell what it does; a reasoner chooses by it")
    require(
        isinstance(treatment.result, type) and issubclass(treatment.result, Result) and treatment.result is not Result,
        f"{treatment.name}: result must be a type of its own that subclasses Result",
    )


def _check_result(treatment: Treatment, result: Result, domain: DomainSpec, where: str) -> None:
    require(isinstance(result, treatment.result), f"{where}: returned {type(result).__name__}, not {treatment.result.__name__}")
    try:
        again = msgspec.json.decode(msgspec.json.encode(result), type=treatment.result)
    except (msgspec.MsgspecError, TypeError, ValueError, OverflowError) as error:
        raise ContractBroken(f"{where}: its result does not survive JSON: {error}") from error
    require(again == result, f"{where}: its result comes back from JSON changed (infinite or NaN numbers, lists for tuples?)")
    require(bool(result.says.strip()) and "\n" not in result.says, f"{where}: says must be one line for a person")
    require(bool(result.rests_on), f"{where}: rests_on is empty; name at least the event or rule it used")
    require(bool(result.would_change), f"{where}: would_change is empty; say what evidence would change the result")
    require(
        isfinite(result.confidence) and 0.0 <= result.confidence <= 1.0, f"{where}: confidence {result.confidence} not in [0, 1]"
    )
    if result.forecast is not None:
        _check_forecast(result.forecast, domain, where)
    for proposal in result.proposes:
        require(bool(proposal.effect.strip()), f"{where}: it proposes an effect without words")
        require(bool(proposal.preconditions), f"{where}: it proposes {proposal.effect!r} without preconditions")
        require(proposal.valid_until_ns is not None, f"{where}: it proposes {proposal.effect!r} without an end of validity")


def _check_forecast(forecast: Forecast, domain: DomainSpec, where: str) -> None:
    labels = domain.outcome.labels
    require(forecast.label in labels, f"{where}: forecasts {forecast.label!r}, which is none of {', '.join(labels)}")
    shares = {forecast.label: forecast.probability, **forecast.probabilities}
    require(set(shares) <= set(labels), f"{where}: forecasts labels that the domain doesn't know")
    require(all(0.0 <= share <= 1.0 for share in shares.values()), f"{where}: a forecast probability is not in [0, 1]")
    if forecast.probabilities:
        total = sum(forecast.probabilities.values())
        require(abs(total - 1.0) < 1e-3, f"{where}: forecast probabilities sum to {total}")
        best = max(forecast.probabilities.values())
        require(forecast.probability >= best - 1e-9, f"{where}: forecasts {forecast.label!r}, though another label is likelier")


def _check_repeatable(
    treatment: Treatment,
    event: Event,
    domain: DomainSpec,
    script: Script,
    mode: Mode,
    recorded: Sequence[Exchange],
    result: Result,
    where: str,
) -> None:
    """The same event and answers give the same requests and result, from JSON too, and after an eviction at any await."""
    copy = msgspec.json.decode(msgspec.json.encode(event), type=Event)
    fresh = ScriptedMind(domain, mode, script)
    require(fresh.run(treatment, copy) == result, f"{where}: a second run over the same script gave another result")
    require(fresh.exchanges == list(recorded), f"{where}: a second run over the same script asked for something else")
    for stop in range(len(recorded)):
        evicted = ScriptedMind(domain, mode, script, recorded)
        try:
            evicted.run(treatment, event, stop_after=stop)
        except Evicted:
            continue
        raise ContractBroken(f"{where}: over {stop} recorded answers it ended, which it had not done at first")
    told = Script(now_s=script.now_s, prior=script.prior, advice=script.advice, consults=script.consults)
    rebuilt = ScriptedMind(domain, mode, told, recorded)
    require(rebuilt.run(treatment, event) == result, f"{where}: over its recorded answers it came to another result")
    require(len(rebuilt.exchanges) == len(recorded), f"{where}: over its recorded answers it stopped asking early")


def _check_in_time(event: Event, script: Script, mind: ScriptedMind, where: str) -> None:
    if event.deadline_s is None or not isfinite(event.deadline_s):
        return
    deadline_s = to_s(event.stamp.received_ns) + event.deadline_s
    late = mind.now_s > max(deadline_s, script.now_s) + 1e-6
    waited = any(each.request.within_s for each in mind.exchanges)
    require(not (late and waited), f"{where}: it waited past the deadline ({mind.now_s:.3f} s, due {deadline_s:.3f} s)")


def _check_alone(treatment: Treatment, event: Event, domain: DomainSpec, script: Script, mode: Mode, where: str) -> None:
    """A mind that knows nothing and answers nobody: every wait's end and every empty recall must lead to a result."""
    alone = ScriptedMind(domain, mode, Script(now_s=script.now_s))
    try:
        result = alone.run(treatment, event)
    except Refusal:
        # the kernel goes on in fallback mode; there it has nowhere left to go
        require(mode == "delib", f"{where}: with nobody to answer it raised Refusal; only a deliberating treatment may give up")
        return
    _check_result(treatment, result, domain, f"{where}, with nothing to go on")
    _check_in_time(event, Script(now_s=script.now_s), alone, f"{where}, with nothing to go on")

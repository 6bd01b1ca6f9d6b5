"""The reasoners by name."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from wakeful.contracts.reasoner import Reasoner, ReasonerError
from wakeful.deliberation.breaker import Breaker
from wakeful.deliberation.budget import Budget, Spent
from wakeful.deliberation.cache import ReplyCache
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.deliberation.openai_reasoner import OpenAIReasoner
from wakeful.deliberation.permit import Permit
from wakeful.deliberation.rate import RateLimit
from wakeful.deliberation.scripted import ScriptedReasoner
from wakeful.deliberation.settings import ReasonerSettings, SettingsError
from wakeful.facts.domain import DomainSpec

#: A token is at least one byte, a character at most four.
_UTF8_BYTES = 4

_NO_KEY = "no-key"  # the SDK refuses an empty one, and a local server reads none

Factory = Callable[[DomainSpec, ReasonerSettings, Mapping[str, str], Spent], Reasoner]


def make(
    name: str,
    spec: DomainSpec,
    settings: ReasonerSettings,
    meanings: Mapping[str, str] | None = None,
    spent: Spent | None = None,
) -> Reasoner:
    """A reasoner by its name.

    Args:
        name: one of REASONERS.
        spec: the domain that it reasons about.
        settings: see ``settings.from_environment``.
        meanings: one sentence for each option that has one, such as a treatment's ``says``; shown to a model.
        spent: what an earlier run of the same journal spent of the budget.

    Raises:
        SettingsError: there is no such reasoner, or a setting that it needs is not there.
        ReasonerError: its extra is not installed.
    """
    try:
        factory = REASONERS[name]
    except KeyError:
        raise SettingsError(f"there is no reasoner {name!r}; there are {', '.join(sorted(REASONERS))}") from None
    return factory(spec, settings, meanings or {}, spent or Spent(0, 0.0))


def permit(settings: ReasonerSettings, spent: Spent) -> Permit:
    """The gate that the settings describe, on this machine's monotonic clock."""
    return Permit(
        Budget(settings.max_usd, settings.max_calls, _at_worst(settings, spent)),
        RateLimit(settings.calls_per_minute, time.monotonic),
        Breaker(settings.breaker_failures, settings.breaker_pause_s, time.monotonic),
    )


def _at_worst(settings: ReasonerSettings, spent: Spent) -> Spent:
    """What was spent at most: an answer in doubt may have taken all its tries, and those of its repair, at the longest prompt."""
    calls = spent.in_doubt * 2 * settings.tries
    tokens_usd = _UTF8_BYTES * settings.max_prompt_chars * settings.price_in_usd_per_m
    call_usd = (tokens_usd + settings.max_answer_tokens * settings.price_out_usd_per_m) / 1_000_000
    return Spent(spent.calls + calls, spent.usd + calls * call_usd)


def _guidelines(spec: DomainSpec, settings: ReasonerSettings, _meanings: Mapping[str, str], _spent: Spent) -> Reasoner:
    return GuidelineReasoner(spec, settings.guideline_latency_s)


def _scripted(spec: DomainSpec, settings: ReasonerSettings, _meanings: Mapping[str, str], _spent: Spent) -> Reasoner:
    return ScriptedReasoner(
        GuidelineReasoner(spec).decide,
        seed=settings.seed,
        error_rate=settings.error_rate,
        forecast_error_rate=settings.forecast_error_rate,
        refusal_rate=settings.refusal_rate,
        latency_s=settings.guideline_latency_s,
    )


def _openai(spec: DomainSpec, settings: ReasonerSettings, meanings: Mapping[str, str], spent: Spent) -> Reasoner:
    if settings.base_url is None:
        raise SettingsError(
            "the openai reasoner sends to no endpoint that was not named: set WAKEFUL_OPENAI_BASE_URL "
            "(such as https://api.deepseek.com, or http://127.0.0.1:8080/v1 for a local server)"
        )
    try:
        from wakeful.deliberation.sdk import SdkEndpoint  # noqa: PLC0415 - an extra, and a second to import
    except ImportError as missing:
        raise ReasonerError(f"the openai reasoner needs its extra: pip install 'wakeful[openai]' ({missing})") from missing
    endpoint = SdkEndpoint(
        base_url=settings.base_url,
        api_key=settings.api_key.reveal() or _NO_KEY,
        model=settings.model,
        max_answer_bytes=settings.max_answer_bytes,
        max_answer_tokens=settings.max_answer_tokens,
    )
    cache = ReplyCache(settings.cache) if settings.cache is not None else None
    return OpenAIReasoner(spec, settings, endpoint, permit(settings, spent), cache, meanings)


REASONERS: dict[str, Factory] = {"guidelines": _guidelines, "openai": _openai, "scripted": _scripted}

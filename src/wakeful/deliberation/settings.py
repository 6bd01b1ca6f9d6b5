"""Settings of the reasoners, from the environment (twelve-factor): every field has a variable and a meaning in VARIABLES."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal, get_type_hints
from urllib.parse import urlsplit

import msgspec

from wakeful.deliberation.cache import default_folder

ResponseFormat = Literal["json_object", "json_schema"]
Above0 = Annotated[float, msgspec.Meta(gt=0, le=1e9)]
From0 = Annotated[float, msgspec.Meta(ge=0, le=1e9)]
Count = Annotated[int, msgspec.Meta(ge=1, le=10**9)]
Rate = Annotated[float, msgspec.Meta(ge=0, le=1)]


class SettingsError(ValueError):
    """A setting that cannot be used. The message names the variable, what is wrong, and what to do."""


class Secret:
    """A value that shows itself nowhere: not in a message, a trace, a prompt or a journal.

    >>> Secret("sk-1")
    Secret(…)
    """

    def __init__(self, value: str) -> None:
        self._value = value

    def reveal(self) -> str:
        """The value, for the one place that sends it."""
        return self._value

    def __repr__(self) -> str:
        return "Secret(…)"

    def __bool__(self) -> bool:
        return bool(self._value)


class ReasonerSettings(msgspec.Struct, frozen=True, kw_only=True):
    """What the reasoners read; see VARIABLES for each field's meaning."""

    base_url: str | None = None
    api_key: Secret = Secret("")
    model: str = "deepseek-v4-flash"
    response_format: ResponseFormat = "json_object"
    deadline_s: Above0 = 30.0
    tries: Annotated[int, msgspec.Meta(ge=1, le=20)] = 4
    backoff_s: From0 = 0.5
    backoff_limit_s: From0 = 8.0
    calls_per_minute: Count | None = 60
    max_calls: Annotated[int, msgspec.Meta(ge=0)] | None = 1000
    max_usd: From0 | None = None
    price_in_usd_per_m: From0 = 0.0
    price_out_usd_per_m: From0 = 0.0
    breaker_failures: Count = 5
    breaker_pause_s: Above0 = 30.0
    max_prompt_chars: Count = 60_000
    max_answer_bytes: Count = 200_000
    max_answer_tokens: Count = 1_000
    cache: Path | None = None
    latency_s: From0 = 2.0
    guideline_latency_s: From0 = 0.2
    seed: int = 0
    error_rate: Rate = 0.0
    forecast_error_rate: Rate = 0.0
    refusal_rate: Rate = 0.0


#: field -> (its variables, the first that is set counts; what it means).
VARIABLES: dict[str, tuple[tuple[str, ...], str]] = {
    "base_url": (
        ("WAKEFUL_OPENAI_BASE_URL", "OPENAI_BASE_URL"),
        "the OpenAI-compatible endpoint; nothing is sent before it is named",
    ),
    "api_key": (("OPENAI_API_KEY",), "the endpoint's key; a local server usually needs none"),
    "model": (("WAKEFUL_MODEL",), "the model's name at the endpoint"),
    "response_format": (
        ("WAKEFUL_RESPONSE_FORMAT",),
        "json_object, or json_schema where the endpoint holds its model to one (llama.cpp, vLLM, OpenAI; not DeepSeek)",
    ),
    "deadline_s": (("WAKEFUL_DEADLINE_S",), "how long one answer may take: calls, retries, waits and repair together"),
    "tries": (("WAKEFUL_TRIES",), "how often one request is tried"),
    "backoff_s": (("WAKEFUL_BACKOFF_S",), "the wait after the first failure; it doubles, with jitter"),
    "backoff_limit_s": (("WAKEFUL_BACKOFF_LIMIT_S",), "the longest wait, unless the endpoint's Retry-After asks for more"),
    "calls_per_minute": (("WAKEFUL_CALLS_PER_MINUTE",), "calls in any 60 s; none: no limit"),
    "max_calls": (("WAKEFUL_MAX_CALLS",), "calls in all, charged when intended; none: no limit"),
    "max_usd": (
        ("WAKEFUL_MAX_USD",),
        "money in all, charged at the worst case when a call is intended; needs the prices; none: no limit",
    ),
    "price_in_usd_per_m": (("WAKEFUL_PRICE_IN_USD_PER_M",), "dollars for a million prompt tokens"),
    "price_out_usd_per_m": (("WAKEFUL_PRICE_OUT_USD_PER_M",), "dollars for a million answer tokens"),
    "breaker_failures": (("WAKEFUL_BREAKER_FAILURES",), "failed calls in a row after which the endpoint is left alone"),
    "breaker_pause_s": (("WAKEFUL_BREAKER_PAUSE_S",), "for how long, before one trial call"),
    "max_prompt_chars": (("WAKEFUL_MAX_PROMPT_CHARS",), "longer prompts are refused, not cut"),
    "max_answer_bytes": (("WAKEFUL_MAX_ANSWER_BYTES",), "an answer is read up to here and dropped beyond"),
    "max_answer_tokens": (("WAKEFUL_MAX_ANSWER_TOKENS",), "the most a model may write; the money budget counts with it"),
    "cache": (("WAKEFUL_REPLY_CACHE",), "folder of kept replies; off: none; default: the user's cache folder"),
    "latency_s": (("WAKEFUL_LATENCY_S",), "what a model's answer takes in virtual time"),
    "guideline_latency_s": (("WAKEFUL_GUIDELINE_LATENCY_S",), "what an answer by guidelines or script takes in virtual time"),
    "seed": (("WAKEFUL_REASONER_SEED",), "seed of the jitter, and of the scripted reasoner's errors"),
    "error_rate": (("WAKEFUL_SCRIPTED_ERROR_RATE",), "share of wrong choices of the scripted reasoner"),
    "forecast_error_rate": (("WAKEFUL_SCRIPTED_FORECAST_ERROR_RATE",), "share of its wrong forecasts"),
    "refusal_rate": (("WAKEFUL_SCRIPTED_REFUSAL_RATE",), "share of questions that it refuses"),
}


def from_environment(environment: Mapping[str, str]) -> ReasonerSettings:
    """Read the settings. A variable that is empty counts as not set.

    Args:
        environment: usually ``os.environ``.

    Raises:
        SettingsError: a value is of the wrong type or out of range, the URL is no http(s) URL or holds a password, or a money
            budget is set without the prices that it needs.
    """
    types = get_type_hints(ReasonerSettings, include_extras=True)
    chosen: dict[str, object] = {"cache": default_folder(environment)}
    for field, (variables, _) in VARIABLES.items():
        variable = next((name for name in variables if environment.get(name, "").strip()), None)
        if variable is None:
            continue
        text = environment[variable].strip()
        if field == "api_key":
            chosen[field] = Secret(text)
        elif field == "cache":
            chosen[field] = None if text == "off" else Path(text).expanduser()
        else:
            try:
                chosen[field] = msgspec.convert(None if text == "none" else text, types[field], strict=False)
            except msgspec.ValidationError as error:
                raise SettingsError(f"{variable}={text!r} cannot be used: {error}") from None
    settings = msgspec.structs.replace(ReasonerSettings(), **chosen)
    _check(settings)
    return settings


def _check(settings: ReasonerSettings) -> None:
    if settings.base_url is not None:
        url = urlsplit(settings.base_url)
        if url.scheme not in ("http", "https") or not url.hostname:
            raise SettingsError("WAKEFUL_OPENAI_BASE_URL must be an http or https address, such as https://api.deepseek.com")
        if url.username or url.password:
            raise SettingsError("WAKEFUL_OPENAI_BASE_URL holds a name or password; give the key in OPENAI_API_KEY instead")
    if settings.max_usd is not None and not (settings.price_in_usd_per_m and settings.price_out_usd_per_m):
        raise SettingsError(
            "WAKEFUL_MAX_USD needs WAKEFUL_PRICE_IN_USD_PER_M and WAKEFUL_PRICE_OUT_USD_PER_M: without prices no call costs"
        )

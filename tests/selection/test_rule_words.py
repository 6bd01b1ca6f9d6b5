"""Learned rules in the domain's own names and units."""

from __future__ import annotations

import pytest

from tests.selection.test_features import ENCODER
from wakeful.contracts.grounds import Ask, HeardRule
from wakeful.selection.rule_words import RuleWords

WORDS = RuleWords(ENCODER)


def at(name: str) -> int:
    return ENCODER.columns.index(name)


@pytest.mark.parametrize(
    ("column", "above", "words"),
    [
        ("state=unstable", True, "state is unstable"),
        ("state=unstable", False, "state is not unstable"),
        ("state missing", True, "state is missing"),
        ("load missing", False, "load is known"),
        ("state other", True, "state is no declared value"),
        ("kind=current_left_band", True, "kind is current_left_band"),
        ("safety", True, "safety is set"),
        ("task", False, "no task"),
        ("zone #3", True, "zone #3 (hashed)"),
    ],
)
def test_a_yes_or_no_column_is_said_in_words(column: str, above: bool, words: str) -> None:
    assert WORDS.ask(Ask(column=at(column), limit=0.5, above=above)) == words


def test_a_limit_is_said_in_the_fields_own_unit() -> None:
    assert WORDS.ask(Ask(column=at("load"), limit=0.62, above=True)) == "load > 6.2"
    assert WORDS.ask(Ask(column=at("trace[1]"), limit=0.25, above=False)) == "trace[1] ≤ -0.5"
    assert WORDS.ask(Ask(column=at("criticality"), limit=0.5, above=True)) == "criticality > 1.5"
    assert WORDS.ask(Ask(column=at("flat"), limit=0.5, above=True)) == "flat > 1.5"


def test_a_shifted_limit_holds_of_the_values_where_it_holds_of_the_columns() -> None:
    ask = Ask(column=at("load"), limit=0.7, above=True, other=at("trace[0]"), slope=-0.4)
    assert WORDS.ask(ask) == "load − 2 × trace[0] > 9"
    for load, trace in ((9.5, 0.5), (9.5, 0.2), (7.2, -1.0), (6.8, -1.0)):
        columns = load / 10.0 - 0.4 * (trace + 1.0) / 2.0
        assert (columns > 0.7) == (load - 2.0 * trace > 9.0)


def test_a_rule_joins_what_it_asks_and_the_last_resort_says_so() -> None:
    asks = (Ask(column=at("state=normal"), limit=0.5, above=True), Ask(column=at("load"), limit=0.6, above=False))
    assert WORDS.rule(HeardRule(asks=asks, heard=1.0, share=0.9, support=12)) == "state is normal and load ≤ 6"
    assert WORDS.rule(HeardRule(asks=(), heard=1.0, share=0.9, support=12)) == "none of a list's rules holds"

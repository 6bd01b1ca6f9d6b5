"""No text comes out of its element or attribute."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.web.documents import Parsed
from wakeful.web.markup import clean, element, join


@given(st.text(), st.text())
def test_any_text_stays_text_and_any_attribute_stays_one(words: str, title: str) -> None:
    parsed = Parsed(element("p", words, title=title))
    assert parsed.elements == [("p", {"title": clean(title)})]
    assert "".join(parsed.words) == clean(words)


def test_markup_is_not_escaped_twice() -> None:
    assert element("p", join(element("b", "a<b"), " & c")) == "<p><b>a&lt;b</b> &amp; c</p>"


@pytest.mark.parametrize("letter", ["\x00", "\x1b", "\u202e", "\u2066", "\u200b", "\ue000", "\ud800", "\u0085"])
def test_what_cannot_be_seen_or_turns_text_round_is_left_out(letter: str) -> None:
    assert clean(f"a{letter}b") == "ab"


def test_an_attribute_that_is_false_is_left_out() -> None:
    assert element("input", disabled=True, hidden=False, value=None, data_x=1) == '<input disabled data-x="1">'

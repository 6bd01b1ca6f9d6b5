"""`trust` and `learning` show what experience has taught."""

from __future__ import annotations

import json
from pathlib import Path

from tests.cli.conftest import Wakeful
from wakeful.revision.revision import RevisionSettings


def test_trust_shows_what_each_treatment_earned_and_lost(wakeful: Wakeful, journal: Path) -> None:
    rows = {row["treatment"]: row for row in json.loads(wakeful("trust", "--journal", journal, "--json").stdout)}
    assert rows["diagnosis"]["trust"] == 0.6
    assert (rows["diagnosis"]["lowered"], rows["diagnosis"]["contradicted"], rows["diagnosis"]["supported"]) == (1, 1, 3)
    assert "0.600" in wakeful("trust", "--journal", journal).stdout


def test_learning_lists_model_versions_with_their_lineage(wakeful: Wakeful, journal: Path) -> None:
    rows = [line.split("\t") for line in wakeful("learning", "--journal", journal).stdout.splitlines()]
    assert [row[:2] for row in rows[1:]] == [["1", "0"], ["2", "1"]]
    assert [row[4] for row in rows[1:]] == ["yes", "no"]


def test_a_treatment_whose_trust_never_changed_has_a_number_too(wakeful: Wakeful, journal: Path) -> None:
    rows = {row["treatment"]: row for row in json.loads(wakeful("trust", "--journal", journal, "--json").stdout)}
    assert (rows["planning"]["trust"], rows["planning"]["began"]) == (RevisionSettings().initial, True)
    assert rows["diagnosis"]["began"] is False
    assert f"planning\t{RevisionSettings().initial:.3f}\t" in wakeful("trust", "--journal", journal).stdout


def test_trust_says_what_makes_each_treatment_automatic_and_what_it_lacks(wakeful: Wakeful, journal: Path) -> None:
    rows = {row["treatment"]: row for row in json.loads(wakeful("trust", "--journal", journal, "--json").stdout)}
    for row in rows.values():
        assert "confidence of at least" in row["criterion"]
        assert row["automatic"] is (row["lacking"] == "")
    text = wakeful("trust", "--journal", journal).stdout
    assert "What makes a treatment automatic" in text
    assert "planning: confidence of at least" in text

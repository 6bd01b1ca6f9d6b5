"""The worked example of docs/revision.md, on part of the recording: what rests on a refuted judgement is listed and reopened."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.print_reopening import story


def test_on_the_recorded_arm_a_contradicted_judgement_reopens_what_rests_on_it_in_order_of_risk(
    shared_data: Path, tmp_path: Path
) -> None:
    pytest.importorskip("python_calamine")
    told = story(shared_data / "ur3_cobotops" / "dataset.xlsx", tmp_path, rows=4_000)
    printed = [words for command, words in told if command.startswith("wakeful")]
    listed, reopened, _, audited = printed
    assert "was contradicted" in listed
    rows = [line.split("\t") for line in listed.splitlines() if line.startswith("P") and "\t" in line]
    assert len(rows) >= 10
    still_open = [row for row in rows if "open to correction" in row]
    order = [(-int(row[2]), -float(row[3].split()[0])) for row in still_open]
    assert order == sorted(order)
    assert "decisions reopened at once" in reopened
    assert "nothing was ignored, lost or done twice" in audited

"""The report of several experiments: figures inside the HTML, methods across, the paper's figure below ours."""

from __future__ import annotations

from pathlib import Path

from wakeful.experiments.report import Part, write_report
from wakeful.experiments.rows import Reproduced, Row

ROWS = [
    Row("5", "proposed", "clean", "joint", 77.19, 5.22, 10, 79.53, 3.16, -0.74),
    Row("5", "wakeful", "clean", "joint", 89.38, 1.61, 10),
    Row("5", "proposed", "clean", "automatic", 73.12, 6.15, 10, 75.62, 2.35, -1.06),
    Row("5", "wakeful", "noisy", "joint", 85.47, 2.34, 10),
]


def written(tmp_path: Path) -> tuple[str, str]:
    drawing = tmp_path / "recovery_clean.svg"
    drawing.write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    part = Part(title="Experiment <3>", seeds=range(2000, 2010), found=Reproduced(ROWS, ["a < b"]), figures=[drawing])
    markdown, html = write_report([part], tmp_path)
    return markdown.read_text(), html.read_text()


def test_the_html_needs_no_other_file_and_escapes_what_is_said(tmp_path: Path) -> None:
    _, html = written(tmp_path)
    assert 'src="data:image/svg+xml;base64,' in html
    assert "recovery_clean.svg" not in html
    assert "Experiment &lt;3&gt;" in html
    assert "a &lt; b" in html


def test_methods_stand_side_by_side_with_the_paper_below(tmp_path: Path) -> None:
    markdown, html = written(tmp_path)
    assert "| joint | 77.19 ± 5.22 (paper 79.53 ± 3.16, z -0.74) | 89.38 ± 1.61 |" in markdown
    assert "| automatic | 73.12 ± 6.15 (paper 75.62 ± 2.35, z -1.06) | – |" in markdown
    assert "<th>proposed</th><th>wakeful</th>" in html


def test_what_is_further_than_one_published_deviation_is_marked(tmp_path: Path) -> None:
    _, html = written(tmp_path)
    assert html.count("class=far") == 1


def test_each_workload_has_a_table_and_a_run_of_seeds_is_named_by_its_ends(tmp_path: Path) -> None:
    markdown, _ = written(tmp_path)
    assert "### Table 5, clean" in markdown
    assert "### Table 5, noisy" in markdown
    assert "Seeds: 2000 to 2009." in markdown

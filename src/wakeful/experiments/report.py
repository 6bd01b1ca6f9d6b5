"""Several experiments as one report: Markdown beside its figures, and HTML with the figures inside it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import msgspec

from wakeful.experiments.rows import Reproduced, Row, table_cells

_COLUMNS = ("method", "workload", "metric", "the paper", "ours", "z", "s.e.")
_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:62rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}"
    "table{border-collapse:collapse;font-size:13px;margin:1rem 0}"
    "td,th{padding:.15rem .6rem;border-bottom:1px solid #ddd;text-align:left}"
    "td:nth-child(n+4),th:nth-child(n+4){text-align:right;font-variant-numeric:tabular-nums}img{max-width:100%}"
)
NOTE = (
    "Mean ± sample standard deviation over the seeds. z is the distance from the published mean in published deviations, "
    "s.e. in standard errors of the published ten-seed mean; a dash where the paper has no such cell."
)


class Part(msgspec.Struct, frozen=True):
    """One experiment in a report: what was found, on which seeds, with which figures (SVG files among them are shown)."""

    title: str
    seeds: Sequence[int]
    found: Reproduced
    figures: Sequence[Path] = ()

    @property
    def drawings(self) -> list[Path]:
        """The figures to show."""
        return [path for path in self.figures if path.suffix == ".svg"]

    @property
    def tables(self) -> Mapping[str, list[Row]]:
        """The rows by the paper's table that they stand in."""
        names = sorted({row.table for row in self.found.rows})
        return {name: [row for row in self.found.rows if row.table == name] for name in names}


def write_report(parts: Sequence[Part], out: Path, title: str = "Reproduction") -> list[Path]:
    """Write ``report.md`` and ``report.html`` to a folder that exists; returns both paths."""
    markdown, html = out / "report.md", out / "report.html"
    markdown.write_text(_markdown(parts, title), encoding="utf-8")
    html.write_text(_html(parts, title), encoding="utf-8")
    return [markdown, html]


def _markdown(parts: Sequence[Part], title: str) -> str:
    said = [f"# {title}", "", NOTE]
    for part in parts:
        said += ["", f"## {part.title}", "", f"Seeds: {', '.join(map(str, part.seeds))}."]
        for name, rows in part.tables.items():
            said += ["", f"### Table {name}", "", f"| {' | '.join(_COLUMNS)} |", "|---|---|---|--:|--:|--:|--:|"]
            said += [f"| {' | '.join(cells)} |" for cells in table_cells(rows)]
        said += ["", *(f"- {remark}" for remark in part.found.remarks), ""]
        said += [f"![{path.stem}]({path.name})" for path in part.drawings]
    return "\n".join(said) + "\n"


def _html(parts: Sequence[Part], title: str) -> str:
    said = [f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>']
    said.append(f"<h1>{escape(title)}</h1><p>{escape(NOTE)}</p>")
    for part in parts:
        said.append(f"<h2>{escape(part.title)}</h2><p>Seeds: {', '.join(map(str, part.seeds))}.</p>")
        for name, rows in part.tables.items():
            head = "".join(f"<th>{escape(column)}</th>" for column in _COLUMNS)
            body = "".join(
                "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>" for cells in table_cells(rows)
            )
            said.append(f"<h3>Table {escape(name)}</h3><table><tr>{head}</tr>{body}</table>")
        said.append("<ul>" + "".join(f"<li>{escape(remark)}</li>" for remark in part.found.remarks) + "</ul>")
        for path in part.drawings:
            data = b64encode(path.read_bytes()).decode()
            said.append(f'<p><img alt="{escape(path.stem)}" src="data:image/svg+xml;base64,{data}"></p>')
    return "\n".join(said) + "\n</html>\n"

"""Several experiments as one report: Markdown beside its figures, and HTML with the figures inside it."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import msgspec

from wakeful.experiments.rows import Reproduced, Row, spread

_STYLE = (
    "body{font:15px/1.5 system-ui,sans-serif;max-width:76rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}"
    "nav a{margin-right:1.2rem}table{border-collapse:collapse;font-size:13px;margin:.6rem 0 1.6rem;width:100%}"
    "td,th{padding:.2rem .6rem;border-bottom:1px solid #ddd;text-align:right;vertical-align:top}"
    "td{font-variant-numeric:tabular-nums}"
    "td:first-child,th:first-child{text-align:left}thead th{border-bottom:2px solid #888}"
    "small{display:block;color:#666;font-size:11px}small.far{color:#a33}"
    ".figures{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(34rem,100%),1fr));gap:1rem;align-items:center}"
    ".figures img{width:100%}"
)
NOTE = (
    "Mean ± sample standard deviation over the seeds; below it, where the paper has such a cell, its figure and z, the distance "
    "from the published mean in published deviations (red above one)."
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
    def tables(self) -> Mapping[tuple[str, str], Table]:
        """By the paper's table and the workload; both in the order in which they were measured."""
        rows: dict[tuple[str, str], list[Row]] = {}
        for each in self.found.rows:
            rows.setdefault((each.table, each.workload), []).append(each)
        return {key: Table(own) for key, own in rows.items()}


class Table:
    """The rows of one workload, methods across and metrics down.

    Args:
        rows: at most one for each method and metric.
    """

    def __init__(self, rows: Sequence[Row]) -> None:
        self.methods = list(dict.fromkeys(row.method for row in rows))
        self.metrics = list(dict.fromkeys(row.metric for row in rows))
        self._cells = {(row.metric, row.method): row for row in rows}

    def cells(self, metric: str) -> list[Row | None]:
        """One line of it."""
        return [self._cells.get((metric, method)) for method in self.methods]


def write_report(parts: Sequence[Part], out: Path, title: str = "Reproduction") -> list[Path]:
    """Write ``report.md`` and ``report.html`` to a folder that exists; returns both paths."""
    markdown, html = out / "report.md", out / "report.html"
    markdown.write_text(_markdown(parts, title), encoding="utf-8")
    html.write_text(_html(parts, title), encoding="utf-8")
    return [markdown, html]


def _markdown(parts: Sequence[Part], title: str) -> str:
    said = [f"# {title}", "", NOTE.replace(" (red above one)", "")]
    for part in parts:
        said += ["", f"## {part.title}", "", f"Seeds: {_seeds(part.seeds)}.", ""]
        said += [f"![{_named(path)}]({path.name})" for path in part.drawings]
        said += ["", *(f"- {remark}" for remark in part.found.remarks)]
        for (name, workload), table in part.tables.items():
            said += ["", f"### {_heading(name)}, {workload}", "", f"| metric | {' | '.join(table.methods)} |"]
            said.append("|---|" + "--:|" * len(table.methods))
            for metric in table.metrics:
                cells = [_ours(each) + (f" ({_paper(each)})" if _paper(each) else "") for each in table.cells(metric)]
                said.append(f"| {metric} | {' | '.join(cells)} |")
    return "\n".join(said) + "\n"


def _html(parts: Sequence[Part], title: str) -> str:
    said = [f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(title)}</title><style>{_STYLE}</style>']
    links = "".join(f'<a href="#part{number}">{escape(part.title)}</a>' for number, part in enumerate(parts, 1))
    said.append(f"<h1>{escape(title)}</h1><nav>{links}</nav><p>{escape(NOTE)}</p>")
    for number, part in enumerate(parts, 1):
        said.append(f'<h2 id="part{number}">{escape(part.title)}</h2><p>Seeds: {_seeds(part.seeds)}.</p>')
        said.append('<div class="figures">')
        for path in part.drawings:
            data = b64encode(path.read_bytes()).decode()
            said.append(f'<img alt="{escape(_named(path))}" src="data:image/svg+xml;base64,{data}">')
        said.append("</div><ul>" + "".join(f"<li>{escape(remark)}</li>" for remark in part.found.remarks) + "</ul>")
        for (name, workload), table in part.tables.items():
            said.append(f"<h3>{escape(_heading(name))}, {escape(workload)}</h3>{_html_table(table)}")
    return "\n".join(said) + "\n</html>\n"


def _html_table(table: Table) -> str:
    head = "".join(f"<th>{escape(each)}</th>" for each in ("metric", *table.methods))
    lines = []
    for metric in table.metrics:
        cells = "".join(f"<td>{_html_cell(each)}</td>" for each in table.cells(metric))
        lines.append(f"<tr><td>{escape(metric)}</td>{cells}</tr>")
    return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(lines)}</tbody></table>"


def _html_cell(row: Row | None) -> str:
    paper = _paper(row)
    far = row is not None and row.paper_mean is not None and (row.z is None or abs(row.z) > 1.0)
    return escape(_ours(row)) + (f"<small{' class=far' if far else ''}>{escape(paper)}</small>" if paper else "")


def _ours(row: Row | None) -> str:
    return "–" if row is None else spread(row.mean, row.sd)


def _paper(row: Row | None) -> str:
    if row is None or row.paper_mean is None:
        return ""
    return f"paper {spread(row.paper_mean, row.paper_sd)}" + ("" if row.z is None else f", z {row.z:+.2f}")


def _heading(table: str) -> str:
    return f"Table {table}" if table.isdigit() else table.capitalize()


def _named(path: Path) -> str:
    return path.stem.replace("_", " ")


def _seeds(seeds: Sequence[int]) -> str:
    """A run of consecutive seeds by its ends, others one by one."""
    run = len(seeds) > 2 and list(seeds) == list(range(seeds[0], seeds[0] + len(seeds)))
    return f"{seeds[0]} to {seeds[-1]}" if run else ", ".join(map(str, seeds))

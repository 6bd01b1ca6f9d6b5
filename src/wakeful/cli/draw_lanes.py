"""Draws lanes of time with matplotlib (the extra 'plots')."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wakeful.experiments.plotting import new_figure
from wakeful.facts.events import CRITICAL
from wakeful.facts.processes import State
from wakeful.journal.lanes import Lane, Lanes, Mark, Stretch

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

#: Told apart by lightness too, so that it reads in grey and by the colour-blind.
COLOURS = {State.CREATED: "#d9d9d9", State.ACTIVE: "#1b7837", State.WAITING: "#fdd9a0", State.SUSPENDED: "#9ecae1"}
_WORDS = {State.CREATED: "created", State.ACTIVE: "active", State.WAITING: "waiting", State.SUSPENDED: "suspended"}
_MARKS = {
    "evidence": ("o", "#b2182b", "evidence came"),
    "answer": ("D", "#762a83", "answer came"),
    "limit": ("X", "#666666", "nothing came"),
    "act": ("P", "#000000", "operator"),
}
_ENDS = {"resolved": "✓", "unresolved": "✗ unresolved", "moot": "moot", "cancelled": "✗ cancelled", "abandoned": "✗ abandoned"}
_ARROW = "#b2182b"
_INK = "#222222"

#: A turn of thinking is named where it takes at least this share of the picture's width.
_ROOM = 0.04


def draw(told: Lanes, out: Path, title: str = "") -> None:
    """Draw lanes to an SVG or PNG file, by its suffix.

    Args:
        told: the lanes; the first stands on top.
        out: the file.
        title: above the picture.

    Raises:
        MissingExtra: matplotlib is not installed.
    """
    begin_ns = min(lane.stretches[0].begin_ns for lane in told.lanes)
    end_ns = max(max(lane.stretches[-1].end_ns, *(mark.at_ns for mark in _shown(lane)), 0) for lane in told.lanes)
    scale, unit = _unit(end_ns - begin_ns)

    def x(at_ns: int) -> float:
        return (at_ns - begin_ns) / scale

    figure, axes = new_figure(9.5, 1.6 + 0.5 * len(told.lanes))
    rows = {lane.process: row for row, lane in enumerate(told.lanes)}
    for lane in told.lanes:
        row = rows[lane.process]
        for stretch in lane.stretches:
            left = x(stretch.begin_ns)
            width = x(stretch.end_ns) - left
            high = 0.56 if stretch.state is State.ACTIVE else 0.3
            axes.barh(
                row,
                width,
                left=left,
                height=high,
                color=COLOURS[stretch.state],
                edgecolor=COLOURS[stretch.state],
                linewidth=1,
                zorder=2,
            )
        for name, stretch in _named(lane):
            if x(stretch.end_ns) - x(stretch.begin_ns) > _ROOM * x(end_ns):
                middle = (x(stretch.begin_ns) + x(stretch.end_ns)) / 2
                axes.text(middle, row, name, ha="center", va="center", color="white", fontsize=9, zorder=3)
        for mark in _shown(lane):
            shape, colour, _ = _MARKS[mark.kind]
            axes.plot(x(mark.at_ns), row, shape, color=colour, markeredgecolor="white", markersize=8, zorder=4)
        if lane.end:
            at = (x(lane.stretches[-1].end_ns), row)
            axes.annotate(_ENDS.get(lane.end, lane.end), at, (5, 0), textcoords="offset points", va="center", color=_INK)
    for each in told.preemptions:
        start, tip = (x(each.at_ns), rows[each.preempted]), (x(each.at_ns), rows[each.preempting])
        axes.annotate("", tip, start, arrowprops={"arrowstyle": "-|>", "color": _ARROW, "linewidth": 1.4}, zorder=5)
    axes.set_yticks(list(rows.values()), [_label(lane) for lane in told.lanes])
    axes.set_ylim(len(rows) - 0.5, -0.6)
    span = x(end_ns) or 1.0
    axes.set_xlim(-0.01 * span, span * 1.06)
    axes.set_xlabel(f"kernel time, {unit} since the first of them was created")
    axes.grid(axis="x", color="#e5e5e5", zorder=0)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    if title:
        axes.set_title(title, loc="left", fontsize=11)
    _explain(told, figure, axes)
    figure.savefig(out, dpi=150, metadata={"Date": None} if out.suffix == ".svg" else {"Software": None})


def _shown(lane: Lane) -> list[Mark]:
    return [mark for mark in lane.marks if mark.kind in _MARKS and not mark.says.startswith("recall")]


def _named(lane: Lane) -> list[tuple[str, Stretch]]:
    """Its turns of thinking, as the paper writes them: P1(1), P1(2), or P1 where there was but one."""
    turns = [each for each in lane.stretches if each.state is State.ACTIVE and each.end_ns > each.begin_ns]
    if len(turns) == 1:
        return [(f"P{lane.process}", turns[0])]
    return [(f"P{lane.process}({number})", each) for number, each in enumerate(turns, start=1)]


def _label(lane: Lane) -> str:
    critical = "  !" if lane.criticality >= CRITICAL else ""
    return f"P{lane.process}  {lane.treatment}{critical}\n{lane.kind} of {lane.entity}"


def _unit(span_ns: int) -> tuple[float, str]:
    """Nanoseconds in a unit that makes the span readable, and its name."""
    if span_ns < 1_000_000:
        return 1e3, "µs"
    return (1e6, "ms") if span_ns < 2_000_000_000 else (1e9, "s")


def _explain(told: Lanes, figure: Figure, axes: Axes) -> None:
    """The legend, with only what the picture shows."""
    states = {stretch.state for lane in told.lanes for stretch in lane.stretches if stretch.end_ns > stretch.begin_ns}
    kinds = {mark.kind for lane in told.lanes for mark in _shown(lane)}
    for state in (state for state in COLOURS if state in states):
        axes.barh(0, 0, color=COLOURS[state], label=_WORDS[state])
    for kind, (shape, colour, says) in _MARKS.items():
        if kind in kinds:
            axes.plot([], [], shape, color=colour, markeredgecolor="white", label=says)
    if told.preemptions:
        axes.plot([], [], "-", marker=">", color=_ARROW, label="preempts")
    figure.legend(loc="outside lower center", ncols=8, frameon=False, fontsize=9, handlelength=1.2)

"""Draws the process table: docs/processes.svg and the table in docs/processes.md, from wakeful.facts.processes.TRANSITIONS.

Run it after the table has changed; tests/test_processes_diagram.py fails until the committed drawing agrees.
"""

from __future__ import annotations

from collections import defaultdict
from html import escape
from pathlib import Path

from wakeful.facts.processes import COMPLETIONS, TRANSITIONS, State, Trigger

HERE = Path(__file__).parent
BEGIN, END = "<!-- drawn from the table: begin -->", "<!-- drawn from the table: end -->"

WIDTH, HEIGHT, BOX_W, BOX_H = 900, 480, 130, 46
PLACES = {
    State.CREATED: (110, 70),
    State.ACTIVE: (450, 70),
    State.WAITING: (780, 70),
    State.SUSPENDED: (450, 240),
    State.COMPLETED: (450, 420),
}
#: How far an arrow bows to the left of its direction, in pixels; straight where not named.
BOWS = {
    (State.ACTIVE, State.SUSPENDED): 40,
    (State.SUSPENDED, State.ACTIVE): 40,
    (State.WAITING, State.SUSPENDED): 25,
    (State.ACTIVE, State.COMPLETED): -190,
    (State.CREATED, State.COMPLETED): -100,
    (State.WAITING, State.COMPLETED): 75,
}


def arrows() -> dict[tuple[State, State], list[Trigger]]:
    """The table as arrows: every pair of states that some trigger joins, with those triggers."""
    joined: dict[tuple[State, State], list[Trigger]] = defaultdict(list)
    for (before, trigger), after in TRANSITIONS.items():
        joined[before, after].append(trigger)
    return dict(joined)


def picture() -> str:
    """The state diagram as SVG."""
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13">',
        "<title>States of a process and the triggers between them</title>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0 8 4 0 8z" fill="#456"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
    ]
    for (before, after), triggers in arrows().items():
        parts += _loop(before, triggers) if before is after else _arrow(before, after, triggers)
    for state, (x, y) in PLACES.items():
        parts.append(
            f'<rect x="{x - BOX_W / 2:g}" y="{y - BOX_H / 2:g}" width="{BOX_W}" height="{BOX_H}" rx="9" '
            'fill="#eef3f7" stroke="#456"/>'
            f'<text x="{x}" y="{y + 5}" text-anchor="middle" font-weight="bold" fill="#123">{escape(state)}</text>'
        )
    return "\n".join([*parts, "</svg>", ""])


def _arrow(before: State, after: State, triggers: list[Trigger]) -> list[str]:
    (x0, y0), (x1, y1) = PLACES[before], PLACES[after]
    length = ((x1 - x0) ** 2 + (y1 - y0) ** 2) ** 0.5
    left_x, left_y = (y1 - y0) / length, -(x1 - x0) / length
    bow = BOWS.get((before, after), 0)
    bend_x, bend_y = (x0 + x1) / 2 + 2 * bow * left_x, (y0 + y1) / 2 + 2 * bow * left_y
    start_x, start_y = _edge(x0, y0, bend_x, bend_y)
    end_x, end_y = _edge(x1, y1, bend_x, bend_y)
    middle_x, middle_y = (start_x + 2 * bend_x + end_x) / 4, (start_y + 2 * bend_y + end_y) / 4
    return [
        f'<path d="M{start_x:.0f} {start_y:.0f} Q{bend_x:.0f} {bend_y:.0f} {end_x:.0f} {end_y:.0f}" fill="none" '
        'stroke="#456" marker-end="url(#tip)"/>',
        *_label(middle_x, middle_y, triggers),
    ]


def _loop(state: State, triggers: list[Trigger]) -> list[str]:
    x, y = PLACES[state]
    edge = x - BOX_W / 2
    return [
        f'<path d="M{edge:g} {y - 12} C{edge - 60:g} {y - 40} {edge - 60:g} {y + 40} {edge:g} {y + 12}" fill="none" '
        'stroke="#456" marker-end="url(#tip)"/>',
        *_label(edge - 70, y, triggers),
    ]


def _edge(x: float, y: float, toward_x: float, toward_y: float) -> tuple[float, float]:
    """Where the line from the box's centre toward a point leaves the box."""
    dx, dy = toward_x - x, toward_y - y
    scale = min(BOX_W / 2 / abs(dx) if dx else float("inf"), BOX_H / 2 / abs(dy) if dy else float("inf"))
    return x + dx * scale, y + dy * scale


def _label(x: float, y: float, triggers: list[Trigger]) -> list[str]:
    top = y - 7.5 * (len(triggers) - 1) + 4
    # White underneath, since not every reader of SVG knows paint-order.
    return [
        f'<text x="{x:.0f}" y="{top + 15 * row:.0f}" text-anchor="middle" {ink}>{escape(trigger)}</text>'
        for row, trigger in enumerate(triggers)
        for ink in ('fill="#fff" stroke="#fff" stroke-width="5"', 'fill="#123"')
    ]


def table() -> str:
    """The table as Markdown: one row a state, what each trigger leads to."""
    rows = ["| from | trigger | to | the process is |", "|---|---|---|---|"]
    for (before, trigger), after in TRANSITIONS.items():
        rows.append(f"| {before} | {trigger} | {after} | {COMPLETIONS.get(trigger, 'open')} |")
    return "\n".join(rows)


def page(text: str) -> str:
    """The page with what stands between its two marks drawn anew."""
    head, rest = text.split(BEGIN)
    _, tail = rest.split(END)
    return f"{head}{BEGIN}\n{table()}\n{END}{tail}"


if __name__ == "__main__":
    (HERE / "processes.svg").write_text(picture())
    (HERE / "processes.md").write_text(page((HERE / "processes.md").read_text()))

"""The learning curve: how the automatic share grew, and whether results stayed right."""

from __future__ import annotations

from collections.abc import Sequence

from wakeful.journal.views import Stretch
from wakeful.journal.wording.words import percent
from wakeful.web.markup import Markup, element, join

_LEAST = 30
"""With fewer events a tenth of them says nothing."""
_LEFT, _TOP, _WIDTH, _HEIGHT = 40, 10, 300, 130


def curve(stretches: Sequence[Stretch]) -> Markup:
    """Automatic share and share of right results by tenths of the events: a drawing, and the same as a table."""
    if sum(stretch.events for stretch in stretches) < _LEAST:
        return element("p", f"With {_LEAST} events there will be a curve here.", class_="calm")
    automatic = [stretch.automatic for stretch in stretches]
    right = [stretch.result.fraction for stretch in stretches]
    says = f"Automatic share from {percent(automatic[0], 0)} in the first tenth to {percent(automatic[-1], 0)} in the last"
    known = [share for share in right if share is not None]
    if known:
        says += f"; results right from {percent(known[0], 0)} to {percent(known[-1], 0)}"
    return join(
        element(
            "figure",
            element(
                "svg",
                element("title", says),
                *(_level(share) for share in (0.0, 0.5, 1.0)),
                *_line(automatic, "line automatic"),
                *_line(right, "line right"),
                *_dots(automatic, "dot automatic"),
                *_dots(right, "dot right"),
                element("text", "first tenth", x=_LEFT, y=_TOP + _HEIGHT + 18),
                element("text", "last", x=_LEFT + _WIDTH, y=_TOP + _HEIGHT + 18, text_anchor="end"),
                viewBox=f"0 0 {_LEFT + _WIDTH + 12} {_TOP + _HEIGHT + 24}",
                role="img",
                class_="curve",
            ),
            element(
                "figcaption",
                element("span", f"automatic {percent(automatic[-1], 0)}", class_="key automatic"),
                element("span", f"results right {percent(known[-1], 0)}", class_="key right") if known else None,
                element("span", "in the last tenth"),
            ),
        ),
        element("details", element("summary", "As a table", id="curve-table"), _table(stretches)),
    )


def _x(index: int, number: int) -> float:
    return _LEFT + _WIDTH * (index / (number - 1) if number > 1 else 0.0)


def _y(share: float) -> float:
    return _TOP + _HEIGHT * (1.0 - share)


def _level(share: float) -> Markup:
    return join(
        element("line", x1=_LEFT, x2=_LEFT + _WIDTH, y1=f"{_y(share):.1f}", y2=f"{_y(share):.1f}", class_="level"),
        element("text", f"{share * 100:.0f} %", x=_LEFT - 6, y=f"{_y(share) + 4:.1f}", text_anchor="end"),
    )


def _line(shares: Sequence[float | None], name: str) -> list[Markup]:
    """The shares as lines, broken where there is none."""
    lines: list[Markup] = []
    part: list[str] = []
    for index, share in enumerate([*shares, None]):
        if share is not None:
            part.append(f"{_x(index, len(shares)):.1f},{_y(share):.1f}")
            continue
        if len(part) > 1:
            lines.append(element("polyline", points=" ".join(part), class_=name))
        part = []
    return lines


def _dots(shares: Sequence[float | None], name: str) -> list[Markup]:
    return [
        element("circle", cx=f"{_x(index, len(shares)):.1f}", cy=f"{_y(share):.1f}", r=3, class_=name)
        for index, share in enumerate(shares)
        if share is not None
    ]


def _table(stretches: Sequence[Stretch]) -> Markup:
    head = element("tr", *(element("th", name, scope="col") for name in ("Tenth", "Events", "Automatic", "Results right")))
    rows = (
        element(
            "tr",
            element("th", index, scope="row"),
            element("td", f"{stretch.events:,}"),
            element("td", percent(stretch.automatic, 0)),
            element("td", f"{percent(stretch.result.fraction, 0)} of {stretch.result.of:,}" if stretch.result.of else "–"),
        )
        for index, stretch in enumerate(stretches, 1)
    )
    return element("table", element("thead", head), element("tbody", *rows), class_="small")

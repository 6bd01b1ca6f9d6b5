"""Tables, paragraphs and bars: fitted to a terminal, plain and whole where they are piped."""

from __future__ import annotations

import shutil
import sys
import textwrap
from collections.abc import Sequence
from typing import TypeVar

import click

from wakeful.journal.wording.words import plain

T = TypeVar("T")

_PIPED_WIDTH = 110
_NARROWEST = 8
_NARROW = 80
_BLOCKS = "▁▂▃▄▅▆▇█"


def on_terminal() -> bool:
    """Whether a person reads the standard output."""
    return sys.stdout.isatty()


def width() -> int:
    """The letters in a line of text."""
    return min(160, shutil.get_terminal_size((_PIPED_WIDTH, 24)).columns) if on_terminal() else _PIPED_WIDTH


def say(text: str = "", **style: bool | str | None) -> None:
    """One line on standard output, coloured only on a terminal; what outside text could steer a terminal with is left out."""
    text = "".join(letter for letter in text.replace("\n", " ") if letter.isprintable() or letter == "\t")
    click.echo(click.style(text, **style) if style else text)  # type: ignore[arg-type]  # click's own keywords


def heading(text: str) -> None:
    """A heading, with an empty line before it."""
    say()
    say(text, bold=True)


def paragraph(text: str, indent: int = 2, hanging: int = 0, label: str = "") -> None:
    """A paragraph of outside or own text, wrapped, its first line after ``label``."""
    lines = textwrap.wrap(
        plain(text),
        width(),
        initial_indent=" " * indent + label,
        subsequent_indent=" " * (indent + hanging),
        break_long_words=False,
        break_on_hyphens=False,
    )
    for line in lines:
        say(line)


def row(label: str, text: str, width: int = 17) -> None:
    """A labelled row of a list of facts; none where there is nothing to say."""
    if text:
        paragraph(text, 2, width, label.ljust(width))


def table(
    columns: Sequence[str],
    rows: Sequence[Sequence[str]],
    numbers: Sequence[str] = (),
    whole: Sequence[str] = (),
    drop: Sequence[str] = (),
) -> None:
    """Print a table: aligned and cut to the terminal's width, or with tabs and nothing cut where it is piped.

    Args:
        columns: the headings.
        rows: cells as text, as many as headings.
        numbers: headings of columns that are aligned to the right; they are never cut.
        whole: headings of further columns that are never cut.
        drop: headings of columns that a terminal may leave out, in this order, before the last column is cut: all of them where
            it is narrow, else as many as give the last column half of the width.
    """
    clean = [[plain(cell) for cell in row] for row in rows]
    if not on_terminal():
        for row in [list(columns), *clean]:
            say("\t".join(row))
        return
    widest = [max(len(row[index]) for row in [list(columns), *clean]) for index in range(len(columns))]
    kept = _kept(columns, widest, drop, width())
    columns, widest, clean = _only(columns, kept), _only(widest, kept), [_only(row, kept) for row in clean]
    widths = fitted(widest, width(), [index for index, column in enumerate(columns) if column in (*numbers, *whole)])
    say(_line(columns, widths, columns, numbers), bold=True)
    for row in clean:
        say(_line(row, widths, columns, numbers))


def _kept(columns: Sequence[str], widest: Sequence[int], drop: Sequence[str], room: int) -> list[int]:
    """The columns that stay, where the last one is to be cut only after those of ``drop`` were left out."""
    kept = list(range(len(columns)))
    wanted = widest[-1] if room < _NARROW else min(widest[-1], room // 2)
    for name in drop:
        if room - sum(widest[index] + 2 for index in kept[:-1]) >= wanted:
            break
        kept.remove(list(columns).index(name))
    return kept


def _only(cells: Sequence[T], kept: Sequence[int]) -> list[T]:
    return [cells[index] for index in kept]


def fitted(widths: Sequence[int], room: int, whole: Sequence[int] = ()) -> list[int]:
    """Column widths that fit: the widest column gives way first, none below eight letters, those in ``whole`` never.

    >>> fitted([10, 80, 10], 64), fitted([30, 30], 40, whole=[0])
    ([10, 40, 10], [30, 8])
    """
    found = list(widths)
    while sum(found) + 2 * (len(found) - 1) > room:
        widest = max((index for index in range(len(found)) if index not in whole), key=lambda index: found[index], default=-1)
        if widest < 0 or found[widest] <= _NARROWEST:
            break
        found[widest] -= 1
    return found


def _line(cells: Sequence[str], widths: list[int], columns: Sequence[str], numbers: Sequence[str]) -> str:
    fitting = [
        plain(cell, limit).rjust(limit) if column in numbers else plain(cell, limit).ljust(limit)
        for cell, limit, column in zip(cells, widths, columns, strict=True)
    ]
    return "  ".join(fitting).rstrip()


def blocks(fractions: list[float | None]) -> str:
    """Fractions as a row of blocks, a dot where there is none.

    >>> blocks([0.0, 0.5, 1.0, None])
    '▁▅█·'
    """
    return "".join("·" if share is None else _BLOCKS[min(7, int(max(0.0, share) * 8))] for share in fractions)


def bar(fraction: float, width: int = 20) -> str:
    """One fraction as a bar of at most ``width`` letters.

    >>> bar(0.5, 10)
    '█████'
    """
    return "█" * round(max(0.0, min(1.0, fraction)) * width)

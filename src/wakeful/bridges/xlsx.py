"""Spreadsheets and CSV files as observations, one a row."""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Final

from wakeful.bridges.content import Overlong, bounded_lines, digest_of, extra, opened, too_long
from wakeful.bridges.rows import Cells, Unreadable, observations
from wakeful.bridges.unpacking import archive_bytes
from wakeful.contracts.bridge import Item, Peek, SourceError
from wakeful.facts.events import Observation
from wakeful.facts.time import to_s

_SHEETS: Final = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
_TEXTS: Final = (".csv", ".tsv")
_PEEK_ROWS: Final = 100
_MAX_UNPACKED_BYTES: Final = 500_000_000


class XlsxBridge:
    """Reads the first sheet of a spreadsheet, or a CSV file. The first row names the columns.

    A spreadsheet is held in memory as a whole (the format needs it); a CSV file is read line by line.
    """

    name = "xlsx"

    def claims(self, path: Path) -> bool:
        """By suffix."""
        return path.suffix.lower() in (*_SHEETS, *_TEXTS)

    def peek(self, path: Path) -> Peek:
        """The columns; the rows and their duration where a spreadsheet knows them."""
        known = len(sheet) - 1 if path.suffix.lower() in _SHEETS and (sheet := _sheet(path)) else None
        first = [item for item in islice(self.read(path), _PEEK_ROWS) if isinstance(item, Observation)]
        channels = tuple(f"row/{name}" for name in first[0].values) if first else ()
        duration_s = None
        if known and len(first) > 1:
            duration_s = to_s(first[-1].at_ns - first[0].at_ns) / (len(first) - 1) * known
        return Peek(self.name, channels, known, duration_s)

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        """One observation a row; position 0 is the first row under the header."""
        rows = iter(_sheet(path)) if path.suffix.lower() in _SHEETS else _text_rows(path)
        return observations(str(path), rows, after)

    def digest(self, path: Path) -> str:
        """SHA-256 of the file."""
        return digest_of(path)


def _sheet(path: Path) -> list[Cells | Unreadable]:
    with extra("xlsx", "a spreadsheet"):
        from python_calamine import CalamineError, CalamineWorkbook  # noqa: PLC0415
    with opened(path) as file:
        try:
            if zipfile.is_zipfile(file) and archive_bytes(path, _MAX_UNPACKED_BYTES) > _MAX_UNPACKED_BYTES:
                raise ValueError(f"unpacked it holds more than {_MAX_UNPACKED_BYTES:,} bytes")
            file.seek(0)
            workbook = CalamineWorkbook.from_filelike(file)
            sheet = workbook.get_sheet_by_index(0)
            return list(sheet.to_python(skip_empty_area=False))
        except (CalamineError, ValueError, KeyError, IndexError, OverflowError) as failure:
            raise SourceError(f"{path} is not a spreadsheet that can be read ({failure}); open it and save it anew") from failure


def _text_rows(path: Path) -> Iterator[Cells | Unreadable]:
    with opened(path) as file:
        block = file.read(1 << 16)
        if b"\0" in block:
            raise SourceError(f"{path} holds binary data, not text; a table in a file of another kind needs its own suffix")
        file.seek(0)
        head = block.split(b"\n", 1)[0]
        delimiter = max(",;\t|", key=lambda sign: head.count(sign.encode()))
        refused: list[Unreadable] = []
        reader = csv.reader(_texts(bounded_lines(file), refused), delimiter=delimiter)
        while True:
            try:
                row: Cells | Unreadable | None = next(reader, None)
            except csv.Error as failure:
                row = Unreadable(f"line {reader.line_num} is no row: {failure}")
            yield from refused
            refused.clear()
            if row is None:
                return
            if isinstance(row, Unreadable) or row:
                yield row


def _texts(lines: Iterator[bytes | Overlong], refused: list[Unreadable]) -> Iterator[str]:
    """The lines as text; what is overlong is put aside into ``refused``. UTF-8, else the Windows code page of the exporters."""
    for number, line in enumerate(lines):
        if isinstance(line, Overlong):
            refused.append(Unreadable(too_long(line)))
            continue
        try:
            shown = line.decode("utf-8-sig" if number == 0 else "utf-8")
        except UnicodeDecodeError:
            shown = line.decode("cp1252", "replace")
        yield shown

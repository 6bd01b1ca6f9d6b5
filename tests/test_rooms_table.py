"""The table of rooms in docs/architecture.md, held against the code."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

from wakeful import folding, kernel
from wakeful.admission.admission import Admission
from wakeful.admission.overload import Overload
from wakeful.learning.cells import Cells
from wakeful.learning.counsel import Counsel
from wakeful.learning.episodes import Episodes
from wakeful.learning.exemplars import Exemplars
from wakeful.learning.plan import Learning
from wakeful.learning.recent import Recent
from wakeful.registration import Sources, SpecRegistrar
from wakeful.revision import Debts, Revision
from wakeful.scheduling.evidence import EvidenceShelf
from wakeful.scheduling.process_set import ProcessSet
from wakeful.scheduling.scheduler import Scheduler
from wakeful.selection.guarantee import Guarantee
from wakeful.selection.selector import Selector
from wakeful.treatments.registry import Registry
from wakeful.validation import Validation

PAGE = Path(__file__).parents[1] / "docs" / "architecture.md"
CLASSES: dict[str, type] = {
    each.__name__: each
    for each in (
        Sources,
        SpecRegistrar,
        Admission,
        Overload,
        Selector,
        Guarantee,
        Scheduler,
        ProcessSet,
        EvidenceShelf,
        Registry,
        Validation,
        Learning,
        Episodes,
        Exemplars,
        Recent,
        Cells,
        Counsel,
        Revision,
        Debts,
    )
}
ROOMS = {
    "_sources": Sources,
    "_admission": Admission,
    "_overload": Overload,
    "_selector": Selector,
    "_guarantee": Guarantee,
    "_scheduler": Scheduler,
    "_validation": Validation,
    "_learning": Learning,
    "_episodes": Episodes,
    "_exemplars": Exemplars,
    "_recent": Recent,
    "_cells": Cells,
    "_counsel": Counsel,
    "_revision": Revision,
    "_debts": Debts,
}
ROWS = [line.split("|")[1:4] for line in PAGE.read_text().partition("## Rooms")[2].splitlines() if line.startswith("| ")][1:]


def called(cell: str) -> list[tuple[str, list[str]]]:
    return [(name, [one for one in given.split(", ") if one]) for name, given in re.findall(r"`(\w+)\(([^)`]*)\)`", cell)]


def fits(function: object, given: list[str]) -> bool:
    """Whether the names are the function's own, in its order, with all that have no default."""
    parameters = [one for one in inspect.signature(function).parameters.values() if one.name != "self"]  # type: ignore[arg-type]
    needed = [one.name for one in parameters if one.default is inspect.Parameter.empty]
    known = [one.name for one in parameters if one.name in given]
    return known == given and set(needed) <= set(given)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0].strip())
def test_what_the_table_says_of_a_room_is_in_the_code(row: list[str]) -> None:
    _, made, calls = row
    classes = [CLASSES[name] for name, _ in called(made)]
    assert classes
    for name, given in called(made):
        assert fits(CLASSES[name], given), f"{name}{inspect.signature(CLASSES[name])} is not called with {given}"
    assert called(calls)
    for name, given in called(calls):
        owners = [method for each in classes if (method := getattr(each, name, None)) is not None]
        assert any(fits(method, given) for method in owners), f"{name}({', '.join(given)}) is in none of {classes}"


def test_the_kernel_calls_nothing_of_a_room_that_is_not_in_the_table() -> None:
    told = {
        (CLASSES[made], call)
        for row in ROWS
        for made, _ in called(row[1])
        for call, _ in called(row[2])
        if hasattr(CLASSES[made], call)
    }
    source = inspect.getsource(kernel) + inspect.getsource(folding)
    calls = {(ROOMS[room], name) for room, name in re.findall(r"self\.(_\w+)\.(\w+)\(", source) if room in ROOMS}
    assert len(calls) > 20
    assert {f"{room.__name__}.{name}" for room, name in calls - told} == set()

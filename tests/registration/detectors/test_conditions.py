"""A list of what is wrong: each entry appears, repeats, changes and clears."""

from __future__ import annotations

from tests.registration.watching import detector, seen
from wakeful.contracts.detector import Found
from wakeful.facts.events import Phase
from wakeful.facts.values import Value


def listed(lists: list[Value]) -> list[list[tuple[str, Phase | None]]]:
    watcher = detector("conditions", ("t/state.errors",), "{robot}", references="refs", criticality=["FATAL=3"])
    return [
        [
            (item.type, item.phase)
            for item in watcher.observe(seen(index, index, state={"errors": value}))
            if isinstance(item, Found)
        ]
        for index, value in enumerate(lists)
    ]


def test_an_entry_appears_repeats_changes_and_clears() -> None:
    warned, fatal = {"type": "low", "level": "WARNING"}, {"type": "low", "level": "FATAL"}
    assert listed([[], [warned], [warned], [fatal], None, "garbage", [fatal, 7], []]) == [
        [],
        [("low", Phase.RAISED)],
        [("low", Phase.REPEATED)],
        [("low", Phase.CHANGED)],
        [],
        [],
        [("low", Phase.REPEATED)],
        [("low", Phase.CLEARED)],
    ]


def test_entries_with_other_references_are_other_conditions() -> None:
    left = {"type": "blocked", "refs": [{"referenceKey": "node", "referenceValue": "n1"}]}
    right = {"type": "blocked", "refs": [{"referenceKey": "node", "referenceValue": "n2"}]}
    watcher = detector("conditions", ("t/errors",), references="refs", criticality=["FATAL=3"])
    found = [item for item in watcher.observe(seen(0, 0.0, errors=[left, right])) if isinstance(item, Found)]
    assert [item.references for item in found] == [("node=n1",), ("node=n2",)]
    assert [item.phase for item in watcher.observe(seen(1, 1.0, errors=[right])) if isinstance(item, Found)] == [
        Phase.REPEATED,
        Phase.CLEARED,
    ]


def test_a_level_has_the_criticality_it_was_given() -> None:
    watcher = detector("conditions", ("t/errors",), criticality=["FATAL=3"])
    (found,) = watcher.observe(seen(0, 0.0, errors=[{"type": "x", "level": "FATAL", "description": "burnt"}]))
    assert isinstance(found, Found)
    assert (found.criticality, found.says) == (3, "FATAL x: burnt")

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from wakeful.bridges import bridge_for
from wakeful.contracts.bridge import Bridge, Item, Peek, SourceError
from wakeful.facts.events import Observation, Undecodable
from wakeful.testing import ContractBroken, check_bridge


class Lines:
    """A bridge over text: each line is a number, or can't be decoded."""

    name = "lines"

    def claims(self, path: Path) -> bool:
        return path.suffix == ".lines"

    def peek(self, path: Path) -> Peek:
        return Peek(self.name, ("text/number",), len(self._text(path)))

    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        for at, line in enumerate(self._text(path)):
            if at > after:
                yield self.item(at, line)

    def item(self, at: int, line: str) -> Item:
        if line.isdigit():
            return Observation(source="s", position=at, topic="text", at_ns=at, values={"number": int(line)})
        return Undecodable(source="s", position=at, reason="no number", excerpt=line)

    def digest(self, path: Path) -> str:
        return "-".join(self._text(path))

    def _text(self, path: Path) -> list[str]:
        try:
            return path.read_text().split()
        except OSError as error:
            raise SourceError(f"{path} cannot be read: {error.strerror}") from error


class Shy(Lines):
    def claims(self, path: Path) -> bool:
        return False


class Gapped(Lines):
    def item(self, at: int, line: str) -> Item:
        return super().item(2 * at, line)


class Restarting(Lines):
    def read(self, path: Path, after: int = -1) -> Iterator[Item]:
        return super().read(path)


class ByName(Lines):
    def digest(self, path: Path) -> str:
        return path.name


class Raw(Lines):
    def _text(self, path: Path) -> list[str]:
        return path.read_text().split()


class Elsewhere(Lines):
    def peek(self, path: Path) -> Peek:
        return Peek(self.name, ("other/number",))


@pytest.fixture
def source(tmp_path: Path) -> Path:
    path = tmp_path / "numbers.lines"
    path.write_text("1\n2\nthree\n4\n")
    return path


def test_a_bridge_that_keeps_its_contract_passes_and_its_items_come_back(source: Path) -> None:
    assert [type(item).__name__ for item in check_bridge(Lines(), source)] == ["Observation"] * 2 + ["Undecodable", "Observation"]


def test_an_empty_source_is_a_source(tmp_path: Path) -> None:
    path = tmp_path / "empty.lines"
    path.write_text("x")
    assert len(check_bridge(Lines(), path)) == 1


@pytest.mark.parametrize(
    ("bridge", "why"),
    [
        (Shy(), "does not claim"),
        (Gapped(), "position 2 where 1 was due"),
        (Restarting(), "is not what follows"),
        (ByName(), "another name has another digest"),
        (Elsewhere(), "names none of the channels"),
    ],
)
def test_a_bridge_that_breaks_its_contract_is_caught(bridge: Bridge, why: str, source: Path) -> None:
    with pytest.raises(ContractBroken, match=why):
        check_bridge(bridge, source)


def test_an_error_of_another_kind_than_the_contracts_comes_through(source: Path) -> None:
    with pytest.raises(FileNotFoundError):
        check_bridge(Raw(), source)


@pytest.mark.parametrize("name", ["rosbag2_turtlebot", "vda5050", "ur3_cobotops/dataset.xlsx"])
def test_the_bridges_keep_their_contract_on_recorded_sources(name: str, shared_data: Path) -> None:
    source = shared_data / name
    if name == "vda5050":
        source = min(source.rglob("*.json"), key=lambda path: (path.stat().st_size, path))
    check_bridge(bridge_for(source), source)

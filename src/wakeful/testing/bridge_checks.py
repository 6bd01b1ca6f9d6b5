"""The contract that every bridge keeps: positions, resumption, digests and one kind of error."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from wakeful.contracts.bridge import Bridge, Item, SourceError
from wakeful.facts.events import Draft, Observation, Undecodable
from wakeful.testing.broken import ContractBroken, require


def check_bridge(bridge: Bridge, path: Path) -> tuple[Item, ...]:
    """Read a source whole, from the middle, under another name, and where there is none.

    Args:
        bridge: what is checked.
        path: a source that it reads, small enough to be read several times.

    Returns:
        The source's items, for further checks of one's own.

    Raises:
        ContractBroken: it does not keep its contract.
    """
    where = f"bridge {bridge.name} on {path.name}"
    require(bridge.claims(path), f"{where}: does not claim it")
    peek = bridge.peek(path)
    require(peek.bridge == bridge.name, f"{where}: peek says that {peek.bridge} reads it")
    items = tuple(bridge.read(path))
    require(items == tuple(bridge.read(path)), f"{where}: two readings differ")
    _check_positions(items, where)
    positions = [at for at in map(_position, items) if at is not None]
    for after in {positions[0], positions[len(positions) // 2], positions[-1]} if positions else ():
        rest = [item for item in bridge.read(path, after) if _position(item) is not None]
        whole = [item for item in items if (_position(item) or 0) > after]
        require(rest == whole, f"{where}: read(after={after}) is not what follows that position")
    seen = {f"{item.topic}/{name}" for item in items if isinstance(item, Observation) for name in item.values}
    require(not seen or bool(seen & set(peek.channels)), f"{where}: peek names none of the channels that reading gives")
    _check_digest(bridge, path, where)
    _check_absent(bridge, path, where)
    return items


def _position(item: Item) -> int | None:
    return item.position if isinstance(item, Observation | Undecodable | Draft) else None


def _check_positions(items: Sequence[Item], where: str) -> None:
    """Positions count from 0; evidence and outcomes, which carry none, may stand for those that are left out."""
    expected, loose = 0, 0
    for item in items:
        at = _position(item)
        if at is None:
            loose += 1
            continue
        require(expected <= at <= expected + loose, f"{where}: position {at} where {expected} was due")
        expected, loose = at + 1, 0


def _check_digest(bridge: Bridge, path: Path, where: str) -> None:
    digest = bridge.digest(path)
    require(bool(digest) and digest == bridge.digest(path), f"{where}: its digest changes")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / f"copy{path.suffix}"
        if path.is_dir():
            shutil.copytree(path, copy)
        else:
            shutil.copyfile(path, copy)
        require(bridge.digest(copy) == digest, f"{where}: the same content under another name has another digest")


def _check_absent(bridge: Bridge, path: Path, where: str) -> None:
    absent = path.with_name(f"no such source{path.suffix}")
    bridge.claims(absent)
    try:
        list(bridge.read(absent))
    except SourceError as error:
        require(absent.name in str(error) or str(absent) in str(error), f"{where}: the error does not name the source: {error}")
        return
    raise ContractBroken(f"{where}: reading a source that is not there must raise SourceError")

"""The workload as a child finds it: written by ``workload.save``, read without wakeful, whose modules peers must not carry."""

from __future__ import annotations

from pathlib import Path

import msgspec

from benchmarks.peers.lean import Lean, load


class Facts(msgspec.Struct, frozen=True):
    """What a child must know of the workload beside its messages."""

    seed: int
    events: int
    evidence: int
    outcomes: int
    messages: int
    waiting: int
    checksum: str


def facts_of(folder: Path) -> Facts:
    """The facts that were saved."""
    return msgspec.json.decode((folder / "facts.json").read_bytes(), type=Facts)


def messages_of(folder: Path) -> list[bytes]:
    """The messages that were saved."""
    return (folder / "messages.jsonl").read_bytes().split(b"\n")


def lean_of(folder: Path) -> Lean:
    """The model that was saved, folded."""
    return load(folder / "lean.npz")

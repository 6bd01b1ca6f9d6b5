"""The systems by name: what each promises, and how it is made. A peer that is not installed is left out, by name."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import msgspec

from benchmarks.peers.running import Run, System


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """One system. ``variants``: the ways in which it is run; ``elsewhere``: those that another module's class makes."""

    module: str
    name: str
    variants: tuple[str, ...] = ("",)
    durable: bool
    needs: tuple[str, ...] = ()
    elsewhere: dict[str, tuple[str, str]] = {}
    share: float = 1.0
    """Of the workload's events that this system is given: slow ones get fewer, and CPU for each event is what counts."""
    window: int = 256
    """How many messages it takes at once: few where each takes milliseconds, so that none waits long for the others."""
    beside: tuple[str, ...] = ()
    """Files that its user would have to write too."""
    crashes: bool = True
    """Whether it can be restarted on what it kept."""

    def make(self, variant: str, run: Run) -> System:
        """The system, ready to run."""
        module, name = self.elsewhere.get(variant, (self.module, self.name))
        kind: Callable[[Run, str], System] = getattr(import_module(f"benchmarks.peers.{module}"), name)
        return kind(run, variant)

    @property
    def missing(self) -> str:
        """What would have to be installed."""
        return ", ".join(name for name in self.needs if not _found(name))

    def lines_of(self, variant: str) -> int:
        """Lines of code in the adapter, with what it needs beside the peer, that are neither blank, comment nor docstring."""
        names = {f"{name}.py" for name in (self.module, self.elsewhere.get(variant, (self.module, ""))[0])}
        return sum(code_lines(Path(__file__).with_name(name).read_text()) for name in (*names, *self.beside))


def _found(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def code_lines(text: str) -> int:
    """Lines that are not blank, a comment or part of a docstring."""
    count, quoted = 0, False
    for line in map(str.strip, text.splitlines()):
        if line.startswith('"""') and not quoted:
            quoted = line.count('"""') == 1
        elif quoted:
            quoted = '"""' not in line
        else:
            count += bool(line) and not line.startswith("#")
    return count


SYSTEMS: dict[str, Entry] = {
    "wakeful": Entry(
        module="of_wakeful",
        name="Wakeful",
        variants=("stream", "stream-full", "live", "live-full"),
        durable=True,
        beside=("drafting.py", "robot.toml"),
        elsewhere=dict.fromkeys(("live", "live-full"), ("of_wakeful_live", "WakefulLive")),
    ),
    "floor": Entry(module="of_floor", name="Floor", durable=True, crashes=False),
    "dbos": Entry(
        module="of_dbos",
        name="Dbos",
        variants=("sqlite", "postgres"),
        durable=True,
        needs=("dbos",),
        share=0.1,
        window=8,
        beside=("beside.py",),
    ),
    "langgraph": Entry(
        module="of_langgraph",
        name="LangGraph",
        variants=("exit", "async", "sync"),
        durable=True,
        needs=("langgraph", "langgraph.checkpoint.sqlite"),
        share=0.1,
        window=8,
        beside=("beside.py",),
    ),
    "py_trees": Entry(module="of_py_trees", name="PyTrees", durable=False, needs=("py_trees",), beside=("beside.py",)),
    "asyncio": Entry(module="of_asyncio", name="Asyncio", durable=False, beside=("beside.py",)),
}

"""The systems by name: what each promises, and how it is made. A peer that is not installed is left out, by name."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import msgspec

from benchmarks.peers.running import Run, System


class Entry(msgspec.Struct, frozen=True, kw_only=True):
    """One system. ``parts`` are its variants, the first the default; ``lines_in`` is the file that a user would write."""

    module: str
    name: str
    variants: tuple[str, ...]
    durable: bool
    needs: tuple[str, ...] = ()
    elsewhere: dict[str, tuple[str, str]] = {}
    """Variants that are made by another module and class."""
    share: float = 1.0
    """Of the workload's events that this system is given: slow ones get fewer, and CPU for each event is what counts."""
    window: int = 256
    """How many messages it takes at once: few where each takes milliseconds, so that none waits long for the others."""

    def make(self, variant: str, run: Run) -> System:
        """The system, ready to run."""
        module, name = self.elsewhere.get(variant, (self.module, self.name))
        kind: Callable[[Run, str], System] = getattr(import_module(f"benchmarks.peers.{module}"), name)
        return kind(run, variant)

    @property
    def missing(self) -> str:
        """What would have to be installed."""
        return ", ".join(name for name in self.needs if not _found(name))

    @property
    def user_lines(self) -> int:
        """Lines of code in the adapter that are neither blank, comment nor docstring."""
        return code_lines(Path(__file__).with_name(f"{self.module}.py").read_text())


def _found(name: str) -> bool:
    try:
        return find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def code_lines(text: str) -> int:
    """Lines that are not blank, a comment or part of a docstring."""
    count, quoted = 0, False
    for line in map(str.strip, text.splitlines()):
        if line.startswith('"""') or quoted:
            quoted = line.count('"""') % 2 == 1 if line.startswith('"""') and not quoted else quoted and '"""' not in line
            continue
        count += bool(line) and not line.startswith("#")
    return count


SYSTEMS: dict[str, Entry] = {
    "wakeful": Entry(
        module="of_wakeful",
        name="Wakeful",
        variants=("stream", "live", "live-full"),
        durable=True,
        elsewhere=dict.fromkeys(("live", "live-full"), ("of_wakeful_live", "WakefulLive")),
    ),
    "floor": Entry(module="of_floor", name="Floor", variants=("",), durable=True),
    "dbos": Entry(module="of_dbos", name="Dbos", variants=("sqlite",), durable=True, needs=("dbos",), share=0.1, window=32),
    "langgraph": Entry(
        module="of_langgraph",
        name="LangGraph",
        variants=("exit", "async", "sync"),
        durable=True,
        needs=("langgraph", "langgraph.checkpoint.sqlite"),
        share=0.1,
        window=32,
    ),
    "py_trees": Entry(module="of_py_trees", name="PyTrees", variants=("",), durable=False, needs=("py_trees",)),
    "asyncio": Entry(module="of_asyncio", name="Asyncio", variants=("",), durable=False),
}

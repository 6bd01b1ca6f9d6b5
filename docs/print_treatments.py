"""Fills the examples and the measured figures into docs/treatments/*.md, between their marks.

./run python docs/print_treatments.py ../shared/data [NAME…] [--costs]

An example is a real event: a mind that may treat by nothing else reads the whole recording, and of the events of its second half
whose outcome came the one with the surest result is shown, as it was recorded. Which recording is said beside it. Figures are
what the named command printed. `diagnosis`, `risk_prediction`, `memory` and `analogy` take some minutes. `--costs` fills in
what each costs alone: that wants a machine that does nothing else.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from itertools import islice
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec

from wakeful.bridges import bridge_for
from wakeful.contracts.bridge import Item
from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import Domain
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.settings import MindSettings
from wakeful.journal import MemoryJournal
from wakeful.journal.results import in_words, result_fields
from wakeful.journal.views import EventPast, History, ProcessPast, history

HERE = Path(__file__).parent / "treatments"
UR3 = ("ur3_cobotops/dataset.xlsx", "ur3_cobotops")
#: Which recording each treatment's example is of: a path in the shared data, or the name of a simulated robot.
EXAMPLES: Mapping[str, tuple[str, str]] = {
    "description": ("rosbag2_turtlebot", "mobile_base"),
    "memory": UR3,
    "risk_prediction": UR3,
    "planning": ("service_robot", "service_robot"),
    "diagnosis": UR3,
    "analogy": UR3,
    "comparison": UR3,
    "causal_analysis": UR3,
}
SIMULATED = 6_000
FIGURES = {
    "recall": ("memory", ["-m", "benchmarks.recollection"], "memory "),
    "leftout": ("analogy", ["-m", "benchmarks.recollection"], "analogy"),
    "brier": (
        "risk_prediction",
        ["-m", "benchmarks.ur3_risk", "{data}/ur3_cobotops/dataset.xlsx", "--picture", "docs/treatments/ur3_risk.svg"],
        "",
    ),
    "faults": ("diagnosis", ["-m", "benchmarks.diagnosis", "{data}"], ""),
}
LEFT_OUT = ("type", "says", "rests_on", "would_change", "confidence", "forecast", "proposes")


class Only:
    """A domain in which nothing but one treatment may be chosen."""

    def __init__(self, domain: Domain, treatment: str) -> None:
        self._domain = domain
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, treatments=(treatment,))

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own."""
        return self._domain.detectors()

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """The domain's own."""
        return self._domain.simulate(seed)


def example(treatment: str, data: Path) -> str:
    """The example of one treatment, as Markdown."""
    source, family = EXAMPLES[treatment]
    domain = Only(load(family), treatment)
    kernel, learner = assemble(domain, MindSettings())
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(domain.spec), learner)
    path = data / source
    if path.exists():
        bridge = bridge_for(path)
        items, digest = (lambda after: bridge.read(path, after)), bridge.digest(path)
    else:
        items, digest = (lambda after: _simulated(domain, after)), "seed 0"
    for _ in driver.run(source, digest, items):
        pass
    driver.close()
    past, process = _shown(history(journal))
    kind = "The recording" if path.exists() else "No recording has a route graph; the simulated robot"
    return f"**Example.** {kind} `{source}`, {past.event.kind} of {past.event.entity}:\n\n```text\n{_told(past, process)}\n```"


def _simulated(domain: Only, after: int) -> Iterable[Item]:
    return islice(domain.simulate(0) or (), after + 1, SIMULATED)


def _shown(read: History) -> tuple[EventPast, ProcessPast]:
    roots = [(past, root) for past, root in read.roots() if root.concluded is not None]
    later = [(past, root) for past, root in roots[len(roots) // 2 :] if root.judged is not None] or roots
    return max(later, key=lambda pair: (_confidence(pair[1]), len(_says(pair[1])), pair[0].event.id))


def _confidence(process: ProcessPast) -> float:
    value = result_fields(process.concluded.result).get("confidence") if process.concluded is not None else None
    return float(value) if isinstance(value, int | float) else 0.0


def _says(process: ProcessPast) -> str:
    return str(result_fields(process.concluded.result).get("says")) if process.concluded is not None else ""


def _told(past: EventPast, process: ProcessPast) -> str:
    fields = result_fields(process.concluded.result) if process.concluded is not None else {}
    lines = [("event", past.event.says or past.event.kind), ("mode", process.concluded.mode if process.concluded else "")]
    lines += [("says", str(fields.get("says"))), ("confidence", in_words(fields.get("confidence")))]
    lines += [
        (name, in_words(value)) for name, value in fields.items() if name not in LEFT_OUT and value not in (None, [], {}, "")
    ]
    reasons, change = fields.get("rests_on"), fields.get("would_change")
    lines += [("rests on", "; ".join(map(str, reasons)) if isinstance(reasons, list) else "")]
    lines += [("would change it", "; ".join(map(str, change)) if isinstance(change, list) else "")]
    if process.judged is not None:
        lines.append(("then", f"the world showed {process.judged.label!r}: {process.judged.verdict}"))
    return "\n".join(_wrapped(name, text) for name, text in lines if text)


def _wrapped(name: str, text: str) -> str:
    clear = " ".join("".join(letter for letter in text if letter.isprintable()).split())
    short = clear if len(clear) <= 700 else clear[:699] + "…"
    return textwrap.fill(short, 118, initial_indent=f"{name:16}", subsequent_indent=" " * 16, break_long_words=False)


def figures(arguments: list[str], begins: str | tuple[str, ...], data: Path) -> str:
    """What a command printed, the lines that begin so."""
    kept = [line.rstrip() for line in _printed(tuple(each.format(data=data) for each in arguments)) if line.startswith(begins)]
    return "```text\n" + "\n".join(kept) + "\n```"


@cache
def _printed(arguments: tuple[str, ...]) -> list[str]:
    """What a command prints; run once, however many pages show parts of it."""
    command = [sys.executable, *arguments]
    done = subprocess.run(command, cwd=HERE.parent.parent, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def fill(page: Path, mark: str, text: str) -> None:
    """Put the text between the page's marks."""
    pattern = re.compile(rf"(<!-- {mark} -->\n).*?(<!-- /{mark} -->)", re.DOTALL)
    page.write_text(
        pattern.sub(lambda found: f"{found[1]}{text}\n{found[2]}", page.read_text(encoding="utf-8")), encoding="utf-8"
    )


def main() -> None:
    """Fill every page, or those that are named."""
    costs = "--costs" in sys.argv
    given = [each for each in sys.argv[1:] if each != "--costs"]
    data, named = Path(given[0]).resolve(), given[1:]
    for name in named or list(EXAMPLES):
        if not costs:
            fill(HERE / f"{name}.md", "example", example(name, data))
            for mark, (page, arguments, begins) in FIGURES.items():
                if page == name:
                    fill(HERE / f"{name}.md", mark, figures(arguments, begins, data))
        fill(HERE / f"{name}.md", "cost", figures(["benchmarks/treatments.py"], ("treatment ", f"{name} "), data))
        print(f"{name} filled", file=sys.stderr)


if __name__ == "__main__":
    main()

"""Fills the worked example of docs/revision.md: an automatic judgement on a hundred events of the UR3 is contradicted.

./run python docs/print_reopening.py ../shared/data/ur3_cobotops/dataset.xlsx

The first half of the recording teaches one mind, as usual. Its experience is imported by a second mind that reads the second half
like a robot whose outcomes only a person tells, within a day: so its automatic judgements stay open to correction. Then a person
says of one of them that it was wrong. Everything printed is what the commands printed.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
from click.testing import CliRunner

from wakeful.bridges import bridge_for
from wakeful.cli.main import main as wakeful
from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import Domain
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Observation
from wakeful.facts.evidence import Outcome
from wakeful.facts.settings import MindSettings
from wakeful.journal import open_journal
from wakeful.journal.experience import carried, take_up
from wakeful.journal.views import history

ROWS = 7_409
PAGE = Path(__file__).parent / "revision.md"
SHOWN = 12


class ToldByAPerson:
    """The UR3's domain where nobody but a person says how events ended, within a day."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        outcome = msgspec.structs.replace(domain.spec.outcome, within_s=86_400.0, gap_s=None, scope="entity")
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, outcome=outcome, outcomes=())

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own."""
        return self._domain.detectors()

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """The domain's own."""
        return self._domain.simulate(seed)


def driver(path: Path, domain: Domain) -> SimulatedDriver:
    """A mind on a journal."""
    kernel, learner = assemble(domain, MindSettings())
    return SimulatedDriver(kernel, open_journal(path, full_sync=False), GuidelineReasoner(domain.spec), learner)


def read(path: Path, domain: Domain, source: Path, first: int, last: int) -> None:
    """Let a mind read part of the recording, and leave the source open."""
    mind, bridge = driver(path, domain), bridge_for(source)
    run = mind.run(
        source.name, f"{bridge.digest(source)}/{first}", lambda after: islice(bridge.read(source, first + after), last - first)
    )
    for _ in islice(run, last - first):
        pass
    run.close()
    mind.close()
    mind.journal.close()


def judged_by_many(path: Path) -> tuple[str, str, int]:
    """Of the automatic judgements the one made on most events: its first event, treatment and forecast in words, how often."""
    with open_journal(path, read_only=True) as journal:
        roots = [(past, root) for past, root in history(journal).roots() if root.concluded is not None]
    automatic = [(past, root) for past, root in roots if root.concluded.mode == "auto" and root.concluded.forecast is not None]
    made = Counter((root.treatment, root.concluded.forecast.label) for _, root in automatic)
    (treatment, label), count = made.most_common(1)[0]
    first = next(past for past, root in automatic if (root.treatment, root.concluded.forecast.label) == (treatment, label))
    return first.event.id, f"{treatment} forecasts {label!r}", count


def contradict(path: Path, domain: Domain, event: str) -> None:
    """A person says that the event ended otherwise."""
    with open_journal(path, read_only=True) as journal:
        found = history(journal)
    past, root = found.events[event], found.root(event)
    label = next(each for each in reversed(domain.spec.outcome.labels) if each != root.concluded.forecast.label)
    told = Outcome(
        id=f"ana/{event}",
        topic=domain.spec.outcome.topic,
        entity=past.event.entity,
        label=label,
        at_ns=past.event.stamp.source_ns + 10**9,
        event=event,
        origin="person",
        source=past.event.source,
    )
    mind = driver(path, domain)
    mind.put([told], mind.kernel.now_ns)
    mind.close()
    mind.journal.close()


def story(source: Path, folder: Path, rows: int = ROWS) -> list[tuple[str, str]]:
    """The commands, each with what it printed; (what, words) for what is no command."""
    usual = load("ur3_cobotops")
    alone = ToldByAPerson(usual)
    teacher, path = folder / "first_half.db", folder / "ur3.db"
    read(teacher, usual, source, 0, rows // 2)
    with open_journal(teacher, read_only=True) as taught, open_journal(path, full_sync=False) as journal:
        taken = take_up(journal, carried(taught), usual.spec.name)
    read(path, alone, source, rows // 2, rows)
    event, judgement, count = judged_by_many(path)
    began = f"{taken.imported} experiences of the first half imported; of the second {judgement} automatically on {count} events."
    told = [("words", began)]
    contradict(path, alone, event)
    told.append(("words", f"Of the first of these a person says that it was otherwise (event {event[:10]})."))
    for command in (
        ["revisit", event[:10], "--through-model", "--limit", str(SHOWN)],
        ["revisit", event[:10], "--through-model", "--reopen", "--who", "ana", "--why", "the arm was not quiet", "--limit", "1"],
        ["debt", "--limit", "3"],
        ["audit"],
    ):
        done = CliRunner(env={"COLUMNS": "110"}).invoke(wakeful, [*command, "--journal", str(path)])
        told.append(
            (
                " ".join(["wakeful", *(f"'{each}'" if " " in each else each for each in command), "--journal", path.name]),
                done.output,
            )
        )
    return told


def main() -> None:
    """Fill the page."""
    with tempfile.TemporaryDirectory() as folder:
        parts = story(Path(sys.argv[1]).resolve(), Path(folder))
    text = "\n\n".join(
        words if command == "words" else f"```text\n$ {command}\n{words.replace(chr(9), '  ').rstrip()}\n```"
        for command, words in parts
    )
    page = PAGE.read_text(encoding="utf-8")
    pattern = re.compile(r"(<!-- reopening -->\n).*?(<!-- /reopening -->)", re.DOTALL)
    PAGE.write_text(pattern.sub(lambda found: f"{found[1]}{text}\n{found[2]}", page), encoding="utf-8")


if __name__ == "__main__":
    main()

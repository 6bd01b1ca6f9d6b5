"""What diagnosis says of the px4 flights, each event that it was asked about: to be read beside the logs by a person.

Run: `./run python -m benchmarks.diagnosis_px4 ../shared/data/px4_ulog/*.ulg`. Each flight is read whole by a mind of its own that
may treat by nothing but `diagnosis`; the guidelines are the reasoner. A line: the flight's time, the event as it was registered,
and after the arrow what the treatment concluded. The log's own messages stand above them.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec

from wakeful.bridges import bridge_for
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
from wakeful.journal.results import result_fields
from wakeful.journal.views import history

#: What diagnosis adds to a sentence about the next check and the forecast is left out here.
ENDS = ("; look for", "; expect")


class OnlyDiagnosis:
    """A domain in which nothing but diagnosis may be chosen."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain
        self.spec: DomainSpec = msgspec.structs.replace(domain.spec, treatments=("diagnosis",))

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own."""
        return self._domain.detectors()

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """The domain's own."""
        return self._domain.simulate(seed)


def said_of(flight: Path) -> Iterator[tuple[float, str, str]]:
    """The flight's time in seconds, the event, and what diagnosis said of it."""
    domain = OnlyDiagnosis(load("px4_ulog"))
    kernel, learner = assemble(domain, MindSettings(trains=False))
    journal = MemoryJournal()
    driver = SimulatedDriver(kernel, journal, GuidelineReasoner(domain.spec), learner)
    bridge = bridge_for(flight)
    for _ in driver.run(flight.name, bridge.digest(flight), lambda after: bridge.read(flight, after)):
        pass
    driver.close()
    for past, root in history(journal).roots():
        if root.concluded is not None:
            says = str(result_fields(root.concluded.result).get("says")).rstrip(".")
            for end in ENDS:
                says = says.partition(end)[0]
            yield past.event.stamp.source_ns / 1e9, past.event.says or past.event.kind, says.partition(": ")[2] or says


def main() -> None:
    """Print every flight."""
    for name in sys.argv[1:]:
        print(f"{Path(name).name}")
        for at_s, event, says in said_of(Path(name)):
            print(f"  {at_s:8.1f} s  {event}\n              → {says}")


if __name__ == "__main__":
    main()

"""Three recorded streams as events with a class that is known afterwards: what is in an event is data, never instruction."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from hashlib import blake2b
from itertools import pairwise
from pathlib import Path
from random import Random

import msgspec

from wakeful.contracts.detector import DetectorFactory
from wakeful.facts.domain import DomainSpec, FieldSpec, OutcomeSpec
from wakeful.facts.events import Event, Observation, event_id
from wakeful.facts.time import NS_PER_S, Stamp
from wakeful.facts.values import Field

DATA = Path(__file__).parents[2] / "shared" / "data"
"""Beside the checkout; see each reader for the folder that it wants."""
TREATMENT = "diagnosis"
"""The one treatment that all events of a stream get where the class is its result."""

GRAMS = 256
_INITIATORS = {
    "driver": "driver",
    "drive": "driver",
    "operator": "driver",
    "system": "system",
    "software": "system",
    "ads": "system",
}


class Stream(msgspec.Struct, frozen=True):
    """Events in order with their classes and, where there is one, their text; the first ``first`` are to learn and choose on."""

    name: str
    says: str
    spec: DomainSpec
    events: tuple[Event, ...]
    labels: tuple[str, ...]
    first: int
    texts: tuple[str, ...] = ()


def robot_failures(seed: int, folder: Path = DATA / "uci_robot_execution_failures") -> Stream:
    """463 force and torque traces after a failure, in five settings; the files are sorted by class, so the order is drawn."""
    rows: list[tuple[dict[str, Field], str]] = []
    for problem in ("lp1", "lp2", "lp3", "lp4", "lp5"):
        for block in re.split(r"\n\s*\n", (folder / f"{problem}.data").read_text()):
            lines = block.split("\n")
            lines = [line for line in lines if line.strip()]
            if lines:
                trace = tuple(math.asinh(float(number)) for line in lines[1:] for number in line.split())
                rows.append(({"setting": problem, "trace": trace}, lines[0].strip()))
    Random(seed).shuffle(rows)
    fields = {
        "setting": FieldSpec(values=("lp1", "lp2", "lp3", "lp4", "lp5")),
        "trace": FieldSpec(low=-8.0, high=8.0, size=90, meaning="asinh of 15 samples of 3 forces and 3 torques"),
    }
    says = f"UCI robot execution failures, order drawn with seed {seed}"
    return _stream("uci_robot_execution_failures", says, fields, rows, len(rows) // 2)


def outdoor(folder: Path = DATA / "outdoor_robot_stream") -> Stream:
    """4,000 images that a robot took of 40 objects in a garden, in the order of time: 21 colour features each."""
    colours = [[float(number) for number in line.split()] for line in (folder / "outdoorStream.data").read_text().splitlines()]
    labels = (folder / "outdoorStream.labels").read_text().split()
    rows = [
        ({"colour": tuple(math.sqrt(max(0.0, share)) for share in row)}, f"object {label}")
        for row, label in zip(colours, labels, strict=True)
    ]
    fields = {"colour": FieldSpec(size=21, meaning="square roots of the shares of 21 colours")}
    return _stream("outdoor_robot_stream", "an outdoor robot's images, by time", fields, rows, len(rows) // 2)


def disengagements(folder: Path = DATA / "av_disengagements_ca_dmv") -> Stream:
    """Reports of 2021, then those of 2022, each year by date: who took the vehicle out of autonomy, from the text alone."""
    rows: list[tuple[dict[str, Field], str]] = []
    texts: list[str] = []
    first = 0
    for name in (
        "2021-Autonomous-Vehicle-Disengagements-Reports-CSV.csv",
        "2022-Autonomous-Vehicle-Disengagement-Reports-CSV.csv",
    ):
        with (folder / name).open(encoding="latin-1", newline="") as file:
            reports = [row for row in list(csv.reader(file))[1:] if len(row) > 8]
        for report in sorted(reports, key=lambda row: _day(row[2])):
            who = next((_INITIATORS[word] for word in re.findall(r"[a-z]+", report[6].lower()) if word in _INITIATORS), None)
            if who is not None:
                text = " ".join(report[8].split())
                texts.append(text)
                rows.append(({"text": grams(text)}, who))
        first = first or len(rows)
    fields = {"text": FieldSpec(size=GRAMS, meaning=f"hashed words and pairs of words, {GRAMS} columns")}
    says = "Californian disengagement reports, 2021 then 2022, by date"
    stream = _stream("av_disengagements_ca_dmv", says, fields, rows, first)
    return msgspec.structs.replace(stream, texts=tuple(texts))


def grams(text: str) -> tuple[float, ...]:
    """Words and pairs of neighbouring words, hashed into ``GRAMS`` columns; of length 1 where there is any."""
    words = re.findall(r"[a-z]+", text.lower())
    columns = [0.0] * GRAMS
    for token in [*words, *(" ".join(pair) for pair in pairwise(words))]:
        columns[int.from_bytes(blake2b(token.encode(), digest_size=4).digest(), "little") % GRAMS] += 1.0
    length = math.sqrt(sum(value * value for value in columns))
    return tuple(value / length for value in columns) if length else tuple(columns)


def _day(text: str) -> tuple[int, int, int]:
    """The date of a report, written in any of a dozen ways; what cannot be read comes first."""
    numbers = [int(number) for number in re.findall(r"\d+", text)[:3]]
    if len(numbers) < 3:
        return 0, 0, 0
    year, month, day = numbers if numbers[0] > 31 else (numbers[2], numbers[0], numbers[1])
    return (year + 2000 if year < 100 else year), month, day


class Recorded:
    """A domain without detectors: its events are registered already."""

    def __init__(self, stream: Stream) -> None:
        self.spec = stream.spec

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """None."""
        return {}

    def simulate(self, seed: int) -> Iterator[Observation] | None:  # noqa: ARG002
        """Nothing: it is a recording."""
        return None


def _stream(
    name: str, says: str, fields: dict[str, FieldSpec], rows: Sequence[tuple[dict[str, Field], str]], first: int
) -> Stream:
    labels = tuple(label for _, label in rows)
    spec = DomainSpec(
        name=name,
        version=1,
        says=says,
        fields=fields,
        outcome=OutcomeSpec(labels=tuple(sorted(set(labels)))),
        treatments=(TREATMENT,),
    )
    events = tuple(
        Event(
            id=event_id("", name, position, "recorded", 0),
            kind="recorded",
            entity="robot",
            source=name,
            position=position,
            stamp=Stamp(source_ns=position * NS_PER_S, received_ns=position * NS_PER_S),
            fields=values,
        )
        for position, (values, _) in enumerate(rows)
    )
    return Stream(name, says, spec, events, labels, first)

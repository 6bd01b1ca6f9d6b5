"""Novelty, measured: how many familiar events are taken for unfamiliar ones, and how many unfamiliar ones are found.

    ./run python -m benchmarks.novelty [--splits 20]

The false-alarm rate is a setting (`MindSettings.novelty_rate`, `wakeful run --novelty-rate`). In each split the product's learner
is fitted to some of the familiar events, a fifth of them held back, as in a mind. The other familiar ones are asked about, and
events of a sort that it has never met. Wants ../shared/data for the two recorded streams.
"""

from __future__ import annotations

import argparse
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import msgspec
import numpy as np
import numpy.typing as npt

from benchmarks.streams import DATA, outdoor, robot_failures
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.facts.events import Event
from wakeful.facts.inputs import Begin, TrainingJob
from wakeful.facts.lines import Admitted
from wakeful.learning.two_heads import TwoHeads
from wakeful.selection.features import Encoder

Floats = npt.NDArray[np.float64]

RATES = (0.01, 0.05, 0.10)
SIZES = (60, 200, 800)
EVENTS = 2500


class World(msgspec.Struct, frozen=True):
    """Encoded events of sorts that are met, and of one that is not."""

    says: str
    familiar: Floats
    unfamiliar: Floats


def simulated() -> World:
    """The simulated service robot; the category of objects that is rarest is never met."""
    domain = load("service_robot")
    kernel, _ = assemble(domain)
    kernel.feed([Begin(source="simulation", digest="0")], 0)
    events: list[Event] = []
    for position, observation in enumerate(domain.simulate(0) or ()):
        fed = msgspec.structs.replace(observation, source="simulation", position=position)
        events += [line.record.event for line in kernel.feed([fed], fed.at_ns).lines if isinstance(line.record, Admitted)]
        if len(events) >= EVENTS:
            break
    sorts = [str(event.fields.get("category")) for event in events]
    rarest = min(sorted(set(sorts)), key=sorts.count)
    encoder = Encoder(domain.spec, domain.spec.treatments)
    x = np.array([encoder.encode(event) for event in events])
    met = np.array([sort != rarest for sort in sorts])
    return World(f"service_robot, simulated; category {rarest!r} is never met", x[met], x[~met])


def recorded() -> list[World]:
    """Ten of the outdoor robot's forty objects are never met, and one of the five settings of robot failures."""
    if not DATA.is_dir():
        print(f"{DATA} is not there: the recorded streams are left out")
        return []
    found = []
    stream = outdoor()
    x = _encoded(stream.events, Encoder(stream.spec, stream.spec.treatments))
    met = np.array([int(label.split()[1]) < 30 for label in stream.labels])
    found.append(World("outdoor_robot_stream; objects 30 to 39 are never met", x[met], x[~met]))
    stream = robot_failures(0)
    x = _encoded(stream.events, Encoder(stream.spec, stream.spec.treatments))
    met = np.array([event.fields["setting"] != "lp3" for event in stream.events])
    found.append(World("uci_robot_execution_failures; setting lp3 is never met", x[met], x[~met]))
    return found


def _encoded(events: tuple[Event, ...], encoder: Encoder) -> Floats:
    return np.array([encoder.encode(event) for event in events])


def novelties(familiar: Floats, asked: Floats, seed: int) -> Floats:
    """The novelty of each row asked about, by a model that was fitted to the familiar ones."""
    n = len(familiar)
    nothing = np.zeros(n, dtype=np.int64)
    job = TrainingJob(
        training=1,
        base_version=0,
        base_weights=b"",
        watermark=n,
        seed=seed,
        epochs=1,
        treatments=("description",),
        labels=("none",),
        features=familiar,
        treatment=nothing,
        result=nothing,
        refuted=nothing - 1,
        weight=np.ones(n),
        held_back=np.arange(n) % 5 == 4,
    )
    learner = TwoHeads()
    _, weights = learner.train(job)
    return np.array([each.novelty for each in learner.load(weights).estimate_many(asked)])


def main() -> None:
    """Print the table."""
    parse = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parse.add_argument("--splits", type=int, default=20)
    splits = parse.parse_args().splits
    heads = " | ".join(f"false alarms at {rate:.0%} | found at {rate:.0%}" for rate in RATES)
    for world in [simulated(), *recorded()]:
        print(f"\n{world.says} ({len(world.familiar):,} familiar events, {len(world.unfamiliar):,} not; {splits} splits)\n")
        print(f"| learned from | held back | {heads} |\n|---:|---:|{'---:|' * 2 * len(RATES)}")
        for size in SIZES:
            if size > 0.7 * len(world.familiar):
                continue
            alarms: list[Floats] = []
            found: list[Floats] = []
            for split in range(splits):
                order = np.random.default_rng(split).permutation(len(world.familiar))
                fitted, others = order[:size], order[size : size + 400]
                asked = np.concatenate([world.familiar[others], world.unfamiliar[:400]])
                novelty = novelties(world.familiar[fitted], asked, split)
                alarms.append(novelty[: len(others)])
                found.append(novelty[len(others) :])
            cells = []
            for rate in RATES:
                false = [float((each > 1.0 - rate).mean()) for each in alarms]
                caught = [float((each > 1.0 - rate).mean()) for each in found]
                cells.append(f"{np.mean(false):.1%} ± {np.std(false, ddof=1) / np.sqrt(splits):.1%} | {np.mean(caught):.0%}")
            print(f"| {size - size // 5} | {size // 5} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()

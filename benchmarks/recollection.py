"""Analogy on kinds of objects that were never met, and memory's recall of what was met before, in the service robot's world.

Run: `./run python -m benchmarks.recollection [--json]`. Encounters are drawn from the world's own distributions (`world.draw`),
each with the treatment that is right for it. No network is involved: the treatments themselves are asked, over the runtime's
own episodic memory (`learning.Episodes`), in auto mode.

- **Analogy**: one category (item, obstacle, device, unknown) is left out of the 400 remembered encounters, whose right treatments
  were validated; 200 encounters of just that category come. Right is whose `treat_as` is the right treatment. Beside it the
  treatment of the nearest neighbour by the encoder's features, of the five nearest by majority, and the most frequent one.
- **Types**: as above, but what an object is shows only in the word for it (`TYPES`: eight each of items, obstacles and devices,
  written down before anything was run); the category is not told. Two types of each category are left out, drawn by the seed,
  and 200 encounters of just those come. The treatment deliberates, with no reasoner, over attributes alone and with meaning (the
  extra `analogy`); `category told` is what attributes alone reach where the category is a field: no embedding can do better;
  `category by name alone` is the share of all types whose category the encoder finds among the others (no seed: all 24).
- **Memory**: 400 encounters come one after the other, of 40 objects. An encounter is a repeat where the same object was met
  before with the same fields but for load (within a twentieth). Recall is the share of repeats that `memory` says were just so
  before; false alarms the share of the others.

Ten seeds; mean and sample standard deviation over them, and by how much the first method named is ahead of each other one, with
its 95 % interval over the same seeds (paired, t).
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from math import sqrt
from random import Random
from statistics import mean, stdev

import msgspec
import numpy as np

from wakeful.contracts.treatment import Mind
from wakeful.domains import load
from wakeful.domains.service_robot.world import (
    CATEGORIES,
    CONTEXTS,
    HISTORIES,
    LOCATIONS,
    ROUTES,
    STATES,
    Encounter,
    draw,
    right_treatment,
)
from wakeful.facts.asking import Episode, Query
from wakeful.facts.events import Context, Event
from wakeful.facts.experience import Experience, Verdict
from wakeful.facts.lines import Admitted, Concluded, Gained, Judged
from wakeful.facts.results import Forecast
from wakeful.facts.time import NS_PER_S, Stamp, to_s
from wakeful.facts.values import Raw
from wakeful.learning.episodes import Episodes
from wakeful.selection.features import Encoder
from wakeful.testing import Script, ScriptedMind
from wakeful.treatments.analogy import Analogy, AnalogySettings, analogy, liken
from wakeful.treatments.meaning import counts, nearness
from wakeful.treatments.memory import Memory, memory

SEEDS, REMEMBERED, TESTED, OBJECTS, RECALLED = 10, 400, 200, 40, 24
SPEC = load("service_robot").spec
OPTIONS = SPEC.treatments
TYPES = {
    "item": ("mug", "plate", "book", "towel", "parcel", "medicine bottle", "tray", "folder"),
    "obstacle": ("chair", "cart", "suitcase", "ladder", "pallet", "bicycle", "cable drum", "wet floor sign"),
    "device": ("elevator", "charging station", "coffee machine", "dishwasher", "printer", "ventilator", "door opener", "scanner"),
}
"""What objects are called in the test of types."""
LEFT_OUT_TYPES = 2
MEANT = "attributes and meaning"


def encounter(random: Random, category: str) -> Encounter:
    """One of the world's encounters with an object of that category."""
    return Encounter(
        category=category,
        location=draw(random, LOCATIONS),
        state=draw(random, STATES),
        history=draw(random, HISTORIES),
        route=draw(random, ROUTES),
        load=round(random.random(), 3),
        context=draw(random, CONTEXTS),
    )


def event_of(number: int, met: Encounter, entity: str) -> Event:
    """The event as registration would give it."""
    at_ns = (number + 1) * 60 * NS_PER_S
    fields = {name: getattr(met, name) for name in met.__struct_fields__}
    return Event(
        id=f"e{number:05d}",
        kind="object",
        entity=entity,
        source="drawn",
        position=number,
        stamp=Stamp(source_ns=at_ns, received_ns=at_ns),
        fields=fields,
        context=Context(task="deliver" if met.context == "task" else "", safety=met.context == "safety"),
    )


class Remembering:
    """The runtime's episodic memory, filled as the kernel fills it."""

    def __init__(self) -> None:
        self.encoder = Encoder(SPEC, OPTIONS)
        self.episodes = Episodes(self.encoder.encode)
        self._count = 0

    def met(self, event: Event) -> None:
        """The event was admitted."""
        self.episodes.apply(Admitted(event=event))

    def ended(self, event: Event, treatment: str) -> None:
        """It was treated so, and the world supported that."""
        self._count += 1
        forecast = Forecast(label="none", probability=1.0)
        result = Raw(msgspec.json.encode({"type": treatment, "says": "as it should be"}))
        about = {"process": self._count, "event": event.id}
        self.episodes.apply(Concluded(**about, treatment=treatment, mode="delib", result=result, forecast=forecast))
        self.episodes.apply(Judged(**about, predicted="none", label="none", verdict=Verdict.SUPPORTED))
        experience = Experience(
            id=self._count,
            **about,
            treatment=treatment,
            treatment_label=treatment,
            predicted="none",
            outcome="none",
            verdict=Verdict.SUPPORTED,
            mode="delib",
        )
        self.episodes.apply(Gained(experience=experience))

    def recall(self, event: Event) -> tuple[Episode, ...]:
        """The likest, and those of the entity: what a treatment's two recalls give."""
        now_ns = event.stamp.received_ns
        like = self.episodes.search(Query(event=event.id, limit=RECALLED), now_ns)
        own = self.episodes.search(Query(entity=event.entity, limit=RECALLED), now_ns)
        return tuple({each.event: each for each in (*own, *like)}.values())


def left_out(category: str, seed: int) -> dict[str, float]:
    """Treatment accuracy on a category that was never met."""
    random, remembering = Random(f"{category}/{seed}"), Remembering()
    known = {name: share for name, share in CATEGORIES.items() if name != category}
    rows, labels = [], []
    for number in range(REMEMBERED):
        met = encounter(random, draw(random, known))
        event = event_of(number, met, f"thing {number}")
        remembering.met(event)
        remembering.ended(event, right_treatment(met))
        rows.append(remembering.encoder.encode(event).copy())
        labels.append(right_treatment(met))
    features = np.stack(rows)
    commonest = Counter(labels).most_common(1)[0][0]
    right: Counter[str] = Counter()
    for number in range(REMEMBERED, REMEMBERED + TESTED):
        met = encounter(random, category)
        event, truth = event_of(number, met, f"thing {number}"), right_treatment(met)
        remembering.met(event)
        script = Script(now_s=to_s(event.stamp.received_ns), episodes=remembering.recall(event))
        found = ScriptedMind(SPEC, "auto", script).run(analogy, event)
        assert isinstance(found, Analogy)
        order = np.argsort(np.square(features - remembering.encoder.encode(event)).sum(axis=1), kind="stable")[:5]
        nearest = [labels[place] for place in order]
        right["analogy"] += found.treat_as == truth
        right["nearest neighbour"] += nearest[0] == truth
        right["five nearest"] += Counter(nearest).most_common(1)[0][0] == truth
        right["most frequent"] += commonest == truth
    return {name: count / TESTED for name, count in right.items()}


def types_left_out(seed: int, types: Mapping[str, Sequence[str]] = TYPES) -> dict[str, float]:
    """Treatment accuracy on types of objects that were never met, where only their name tells what they are."""
    random, remembering = Random(f"types/{seed}"), Remembering()
    told = Remembering()
    new = {category: set(random.sample(names, LEFT_OUT_TYPES)) for category, names in types.items()}
    shares = {category: CATEGORIES[category] for category in types}

    def meet(number: int, known: bool) -> tuple[Event, Event, str]:
        """An encounter with a type that was met before, or not: without its category, with it, and the right treatment."""
        category = draw(random, shares)
        met = encounter(random, category)
        name = random.choice([each for each in types[category] if (each not in new[category]) == known])
        event = event_of(number, met, f"thing {number}")
        fields = {field: value for field, value in event.fields.items() if field != "category"}
        return msgspec.structs.replace(event, fields={**fields, "thing": name}), event, right_treatment(met)

    rows, labels = [], []
    for number in range(REMEMBERED):
        named, categorised, truth = meet(number, known=True)
        for memory_of, event in ((remembering, named), (told, categorised)):
            memory_of.met(event)
            memory_of.ended(event, truth)
        rows.append(remembering.encoder.encode(named).copy())
        labels.append(truth)
    features = np.stack(rows)
    right: Counter[str] = Counter()
    for number in range(REMEMBERED, REMEMBERED + TESTED):
        named, categorised, truth = meet(number, known=False)
        remembering.met(named)
        told.met(categorised)
        asked = {
            MEANT: (remembering, named, _Likening(meaning=True)),
            "attributes alone": (remembering, named, _Likening(meaning=False)),
            "category told": (told, categorised, _Likening(meaning=False)),
        }
        for name, (memory_of, event, way) in asked.items():
            script = Script(now_s=to_s(event.stamp.received_ns), episodes=memory_of.recall(event))
            found = ScriptedMind(SPEC, "delib", script).run(way, event)
            assert isinstance(found, Analogy)
            right[name] += found.treat_as == truth
        order = np.argsort(np.square(features - remembering.encoder.encode(named)).sum(axis=1), kind="stable")[:5]
        nearest = [labels[place] for place in order]
        right["nearest neighbour"] += nearest[0] == truth
        right["five nearest"] += Counter(nearest).most_common(1)[0][0] == truth
    return {name: right[name] / TESTED for name in (*asked, "nearest neighbour", "five nearest")}


def by_name(types: Mapping[str, Sequence[str]] = TYPES) -> float:
    """The share of types whose category the encoder finds: the one whose other types count most beside it."""
    names = {name: category for category, those in types.items() for name in those}
    right = 0
    for name, category in names.items():
        others = [other for other in names if other != name]
        told = counts(dict(zip(others, nearness([name], others)[0], strict=True)))
        weights = {each: sum(count for other, count in told.items() if names[other] == each) for each in types}
        right += max(weights, key=lambda each: weights[each]) == category
    return right / len(names)


class _Likening:
    """Analogy with or without meaning."""

    name, version, says, result = "analogy", 1, "likens", Analogy

    def __init__(self, meaning: bool) -> None:
        self._settings = AnalogySettings(meaning=meaning)

    async def treat(self, event: Event, mind: Mind) -> Analogy:
        """By the settings."""
        return await liken(event, mind, self._settings)


def repeats(seed: int) -> dict[str, float]:
    """How many repeats memory recalls, and how often it takes something new for a repeat."""
    random, remembering = Random(f"repeats/{seed}"), Remembering()
    objects = [(f"thing {number}", draw(random, CATEGORIES)) for number in range(OBJECTS)]
    standing: dict[str, list[Encounter]] = {}
    told: dict[bool, list[bool]] = {True: [], False: []}
    for number in range(REMEMBERED):
        entity, category = random.choice(objects)
        before = standing.setdefault(entity, [])
        again = bool(before) and random.random() < 0.5
        met = random.choice(before) if again else encounter(random, category)
        event = event_of(number, met, entity)
        repeat = any(_same(met, each) for each in before)
        remembering.met(event)
        script = Script(now_s=to_s(event.stamp.received_ns), episodes=remembering.recall(event))
        found = ScriptedMind(SPEC, "auto", script).run(memory, event)
        assert isinstance(found, Memory)
        told[repeat].append(bool(found.as_before) or (found.sightings > 0 and not found.differs))
        before.append(met)
        remembering.ended(event, right_treatment(met))
    return {"recall of repeats": mean(told[True]), "false alarms": mean(told[False])}


def _same(one: Encounter, other: Encounter) -> bool:
    fields = [name for name in one.__struct_fields__ if name != "load"]
    return all(getattr(one, name) == getattr(other, name) for name in fields) and abs(one.load - other.load) <= 0.05


def rows() -> Iterator[dict[str, object]]:
    """Every figure."""
    for category in CATEGORIES:
        yield from _spread(f"analogy, {category} left out", [left_out(category, seed) for seed in range(SEEDS)], "analogy")
    yield from _spread("analogy, types left out", [types_left_out(seed) for seed in range(SEEDS)], MEANT)
    yield {"what": "analogy, types left out", "figure": "category by name alone", "mean": by_name(), "sd": 0.0, "seeds": 1}
    yield from _spread("memory", [repeats(seed) for seed in range(SEEDS)])


def _spread(what: str, runs: Sequence[dict[str, float]], leads: str = "") -> Iterator[dict[str, object]]:
    for name in runs[0]:
        shares = [run[name] for run in runs]
        found = {"what": what, "figure": name, "mean": mean(shares), "sd": stdev(shares), "seeds": len(runs)}
        if leads and name != leads:
            ahead = [run[leads] - run[name] for run in runs]
            half = 2.262 * stdev(ahead) / sqrt(len(ahead))  # t with 9 degrees of freedom
            found |= {"ahead": mean(ahead), "low": mean(ahead) - half, "high": mean(ahead) + half}
        yield found


def main() -> None:
    """Print the table."""
    found = list(rows())
    if "--json" in sys.argv:
        print(json.dumps(found, indent=2))
        return
    for row in found:
        ahead = [100 * row[name] for name in ("ahead", "low", "high") if name in row]  # type: ignore[operator]
        by = f"   {ahead[0]:+5.1f} ({ahead[1]:+.1f} to {ahead[2]:+.1f})" if ahead else ""
        print(f"{row['what']:28} {row['figure']:22} {100 * row['mean']:5.1f} ± {100 * row['sd']:4.1f} %{by}")  # type: ignore[operator]


if __name__ == "__main__":
    main()

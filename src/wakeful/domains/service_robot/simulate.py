"""The tour: a robot goes from place to place, sees what stands there each second, and hears later what it needed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from heapq import heappop, heappush
from math import hypot
from random import Random

import msgspec

from wakeful.domains.service_robot.world import (
    CATEGORIES,
    CONTEXTS,
    HISTORIES,
    LOCATIONS,
    PLACES,
    ROUTES,
    SIGNATURES,
    STATES,
    Encounter,
    Thing,
    draw,
    needed,
    right_treatment,
)
from wakeful.facts.events import Observation
from wakeful.facts.time import NS_PER_S, to_ns
from wakeful.facts.values import Value

SOURCE = "service_robot"
START_NS = 1_767_596_400 * NS_PER_S
"""Monday 5 January 2026, 07:00 UTC: the shift begins."""

SPEED_M_S = 1.0
REACH_M = 2.5
"""How far from the middle of its place a thing may stand, along each axis."""

MOST_AT_A_PLACE = 7
"""When more stand at a place, somebody has carried the oldest away."""

CHANGES_PER_VISIT = {0: 0.15, 1: 0.45, 2: 0.30, 3: 0.10}
OUTCOME_S = (5.0, 60.0)
READING_S = (8.0, 20.0)
FIRST_TURN_S = (2_400.0, 3_600.0)
NEXT_TURN_S = (3_600.0, 7_200.0)
TOLD = 0.7
"""Share of the encounters which needed nothing whose report says so; the rest stay silent until their window closes."""

TASKS = ("deliver a tray", "inspect the shelf", "clear the route", "fetch a crate")
FAULTS = {"overheating": (78.0, 3.1), "stalled motor": (52.0, 9.0), "blocked fan": (66.0, 2.0), "weak supply": (31.0, 0.6)}
"""Device faults with the temperature (°C) and current (A) that they show."""

Body = dict[str, Value]


def simulate(seed: int) -> Iterator[Observation]:
    """An endless tour. The same seed gives the same observations, to the bit.

    Topics: ``pose`` (where the robot is, once a second), ``sighting`` (one object, once a second while it is in view;
    its ``x`` and ``y`` are metres from the middle of its place),
    ``reading`` (what a device measured, later) and ``report`` (what an encounter turned out to need, 5 to 60 s later).
    Between 40 and 60 minutes in, and every one to two hours after that, the environment turns the outcomes of one signature
    round, or back.
    """
    return iter(_Tour(seed))


class _Tour:
    def __init__(self, seed: int) -> None:
        self._random = Random(f"service_robot {seed}")
        self._now_s = 0.0
        self._position = 0
        self._things: dict[str, list[Thing]] = {place: [] for place in PLACES}
        self._made = 0
        self._scheduled = 0
        self._later: list[tuple[float, int, str, Body]] = []
        self._turned: frozenset[str] = frozenset()
        self._next_turn_s = self._random.uniform(*FIRST_TURN_S)
        self._place = "hall"

    def __iter__(self) -> Iterator[Observation]:
        while True:
            kind = draw(self._random, LOCATIONS)
            goal = self._random.choice([place for place, (location, _, _) in PLACES.items() if location == kind])
            yield from self._travel(goal)
            yield from self._visit()

    def _travel(self, goal: str) -> Iterator[Observation]:
        _, x, y = PLACES[self._place]
        _, goal_x, goal_y = PLACES[goal]
        steps = max(2, round(hypot(goal_x - x, goal_y - y) / SPEED_M_S))
        for step in range(1, steps):
            yield from self._tick()
            share = step / steps
            yield self._observed("pose", {"x": round(x + share * (goal_x - x), 2), "y": round(y + share * (goal_y - y), 2)})
        self._place = goal

    def _visit(self) -> Iterator[Observation]:
        random = self._random
        context = draw(random, CONTEXTS)
        location, _, _ = PLACES[self._place]
        about: Body = {
            "place": self._place,
            "location": location,
            "context": context,
            "task": random.choice(TASKS) if context == "task" else "",
        }
        dwell = random.randint(6, 14)
        count = random.choices(list(CHANGES_PER_VISIT), list(CHANGES_PER_VISIT.values()))[0]
        due = sorted(random.choice((0, 0, random.randrange(dwell))) for _ in range(count))
        for second in range(dwell):
            yield from self._tick()
            _, x, y = PLACES[self._place]
            yield self._observed("pose", {"x": x, "y": y, "place": self._place})
            changed: dict[str, tuple[Thing, Encounter]] = {}
            while due and due[0] == second:
                due.pop(0)
                thing, met = self._change(context, exclude=changed)
                changed[thing.identity] = (thing, met)
            for thing in list(self._things[self._place]):
                if thing.identity in changed:
                    self._follow(*changed[thing.identity], self._position)
                thing.seen = True
                yield self._observed("sighting", {**_seen(thing), **about})

    def _tick(self) -> Iterator[Observation]:
        self._now_s += 1.0
        if self._now_s >= self._next_turn_s:
            self._turned = self._turned ^ {self._random.choice(SIGNATURES).name}
            self._next_turn_s += self._random.uniform(*NEXT_TURN_S)
        while self._later and self._later[0][0] <= self._now_s:
            _, _, topic, values = heappop(self._later)
            yield self._observed(topic, values)

    def _change(self, context: str, exclude: Mapping[str, object]) -> tuple[Thing, Encounter]:
        """Something at this place is new, was moved, or is otherwise not as it was."""
        random = self._random
        here = [thing for thing in self._things[self._place] if thing.seen and thing.identity not in exclude]
        anywhere = [thing for things in self._things.values() for thing in things if thing.seen and thing.identity not in exclude]
        history = draw(random, HISTORIES)
        if history == "unchanged" and here:
            thing = random.choice(here)
        elif history == "moved" and anywhere:
            thing = random.choice(anywhere)
            self._things[thing.place].remove(thing)
            self._put(thing)
        else:
            history = "none"
            thing = self._made_new()
        state, route = draw(random, STATES), draw(random, ROUTES)
        load = round(random.random(), 3)
        while (state, route) == (thing.state, thing.route) and abs(load - thing.load) < 0.2:
            load = round(random.random(), 3)
        thing.state, thing.route, thing.load = state, route, load
        met = Encounter(
            category=thing.category,
            location=PLACES[self._place][0],
            state=state,
            history=history,
            route=route,
            load=load,
            context=context,
        )
        thing.truth = right_treatment(met)
        return thing, met

    def _made_new(self) -> Thing:
        category = draw(self._random, CATEGORIES)
        self._made += 1
        thing = Thing(
            identity=f"{category}-{self._made:04d}", category=category, place="", x=0.0, y=0.0, state="", route="", load=0.0
        )
        self._put(thing)
        return thing

    def _put(self, thing: Thing) -> None:
        """Stand a thing somewhere at this place, at least a metre from where it was."""
        before = (thing.x, thing.y)
        while True:
            thing.x = round(self._random.uniform(-REACH_M, REACH_M), 2)
            thing.y = round(self._random.uniform(-REACH_M, REACH_M), 2)
            if hypot(thing.x - before[0], thing.y - before[1]) >= 1.0:
                break
        thing.place = self._place
        standing = self._things[self._place]
        standing.append(thing)
        if len(standing) > MOST_AT_A_PLACE:
            standing.pop(0)

    def _follow(self, thing: Thing, met: Encounter, position: int) -> None:
        """What will be heard later of the encounter that is observed at ``position``."""
        random = self._random
        label = needed(met, self._turned)
        delay_s = random.uniform(*OUTCOME_S)
        told = label == "intervention" or random.random() < TOLD
        if told:
            self._schedule(delay_s, "report", {"identity": thing.identity, "about": position, "needed": label})
        if thing.category == "device" and met.state != "normal":
            fault = random.choice(list(FAULTS))
            celsius, ampere = FAULTS[fault]
            self._schedule(
                random.uniform(*READING_S),
                "reading",
                {
                    "identity": thing.identity,
                    "temperature_c": round(random.gauss(celsius, 3.0), 1),
                    "current_a": round(max(0.0, random.gauss(ampere, 0.2)), 2),
                    "fault": fault if met.state == "abnormal" else "",
                },
            )

    def _schedule(self, delay_s: float, topic: str, values: Body) -> None:
        self._scheduled += 1
        heappush(self._later, (self._now_s + delay_s, self._scheduled, topic, values))

    def _observed(self, topic: str, values: Body) -> Observation:
        made = Observation(
            source=SOURCE,
            position=self._position,
            topic=topic,
            at_ns=START_NS + to_ns(self._now_s),
            values=values,
            robot="robot",
        )
        self._position += 1
        return made


def _seen(thing: Thing) -> Body:
    body: Body = msgspec.structs.asdict(thing)
    del body["seen"]
    body["truth_treatment"] = body.pop("truth")
    return body

"""The fault plan of one seed: what the world, the reasoner, the clock, the disk and the power do to one mind."""

from __future__ import annotations

from random import Random
from typing import Literal

import msgspec

from wakeful.testing.faulty_disk import Fault, Survival
from wakeful.testing.faulty_reasoner import Manners

#: Crash points, with how often they may be reached before the crash.
CRASHES: dict[str, int] = {
    "journal: file made": 1,
    "journal: schema written": 1,
    "recovery: begun": 1,
    "recovery: folded": 1,
    "recovery: rebuilt": 1,
    "recovery: committed": 1,
    "feed: decided": 30,
    "commit: begun": 30,
    "commit: lines written": 30,
    "commit: state written": 30,
    "commit: done": 30,
    "acting: call": 25,
    "acting: call made": 25,
    "acting: training": 1,
    "publication: trained": 1,
    "publication: decided": 1,
    "publication: committed": 1,
}

_RECOVERY = tuple(name for name in CRASHES if name.startswith("recovery"))
_COMMITS = tuple(name for name in CRASHES if name.startswith(("commit", "feed", "acting: call")))

#: So many waiting processes stay at hand where none is to be parked.
NOBODY_PARKED = 4_096

POLICIES = ("deadline_aware", "deadline_aware", "suspend_resume", "sequential", "primary_share")


class End(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """How one life ends, should it come to that: at a crash point for the n-th time, counted from the life's start.

    ``killed``: the process dies there. ``power``: the machine loses power there, ``survival`` says what becomes of writes that
    were not synced. ``disk``: after ``nth`` writes the disk fails by ``fault``, and is mended before the next life.
    ``commit``: the ``nth`` commit fails, and the next one would succeed.
    """

    how: Literal["killed", "power", "disk", "commit"]
    nth: int
    at: str = ""
    survival: Survival = "none"
    fault: Fault = "full"


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """What one seed does.

    ``seed``: of the script too. ``events``: how many the world offers. ``gap_s``: mean time between two. ``ends``: of lives, one
    after the other. ``manners``: the reasoner's. ``budget``: calls that may be made in all, None: no limit. ``clock_jumps``:
    (number of the item, seconds). ``acts``: whether operators hold, release and cancel. ``rereads``: whether the source is
    read a second time. ``outcomes``: share of the events that the world shows an outcome of. ``slots``, ``reasoner_slots``,
    ``step_s``, ``policy``: of the mind. ``keep_waiting``: so many waiting processes stay at hand, the others are parked; the
    second time nobody is (but live, where rebuilding one takes the time of steps).
    """

    seed: int
    events: int
    gap_s: float
    ends: tuple[End, ...]
    manners: Manners
    budget: int | None
    clock_jumps: tuple[tuple[int, float], ...]
    acts: bool
    rereads: bool
    outcomes: float
    slots: int
    reasoner_slots: int
    step_s: float
    policy: str
    keep_waiting: int

    @property
    def repeatable(self) -> bool:
        """Whether nothing but the ends of lives tells this run from an undisturbed one: then both end alike."""
        return not self.manners.by_the_clock and self.budget is None

    @property
    def needs_disk(self) -> bool:
        """Whether a disk must fail below SQLite."""
        return any(end.how in ("power", "disk") for end in self.ends)


def draw(seed: int) -> Plan:
    """The fault plan of a seed. The same seed, the same plan, on any machine."""
    random = Random(f"chaos {seed}")
    disturbed = random.random() < 0.9
    by_the_clock = random.random() < 0.25
    long = random.random() < 0.05
    return Plan(
        seed=seed,
        events=random.choice((24, 30)) if long else random.choice((3, 4, 5, 6, 8, 10, 12)),
        gap_s=random.choice((0.0, 0.2, 1.0, 4.0)),
        ends=_ends(random, disturbed, long),
        manners=Manners.drawn(random, by_the_clock=by_the_clock),
        budget=random.choice((3, 8, 15)) if by_the_clock and random.random() < 0.4 else None,
        clock_jumps=tuple(
            (random.randrange(16), random.choice((-86_400.0, -30.0, 45.0, 3_600.0, 86_400.0)))
            for _ in range(random.choice((0, 0, 1, 2)))
        ),
        acts=random.random() < 0.25,
        rereads=random.random() < 0.2,
        outcomes=1.0 if long else random.choice((0.2, 0.4)),
        slots=random.choice((1, 1, 2, 4)),
        reasoner_slots=random.choice((0, 1, 2)),
        step_s=random.choice((0.0, 0.02, 0.1, 0.5)),
        policy=random.choice(POLICIES),
        keep_waiting=Random(f"parked {seed}").choice((0, 1, 3, NOBODY_PARKED)),
    )


def _ends(random: Random, disturbed: bool, long: bool) -> tuple[End, ...]:
    if not disturbed:
        return ()
    hard = random.random() < 0.3
    ends = [_end(random, number, hard) for number in range(random.choice((1, 1, 2, 2, 3, 4, 6)))]
    if long:
        at = random.choice(("acting: training", "publication: trained", "publication: decided", "publication: committed"))
        ends.insert(0, End(how="killed", at=at, nth=1))
    return tuple(ends)


def _end(random: Random, number: int, hard: bool) -> End:
    if random.random() < 0.15:
        return End(how="commit", nth=random.randint(1, 20))
    if hard and random.random() < 0.4:
        return End(how="disk", nth=random.randint(1, 80), fault=random.choice(("full", "read-only", "broken")))
    if number and random.random() < 0.3:
        at = random.choice(_RECOVERY)
    elif number == 0 and random.random() < 0.05:
        at = random.choice(("journal: file made", "journal: schema written"))
    else:
        at = random.choice(_COMMITS)
    nth = random.randint(1, CRASHES[at])
    if hard:
        return End(how="power", at=at, nth=nth, survival=random.choice(("none", "some", "some", "all")))
    return End(how="killed", at=at, nth=nth)

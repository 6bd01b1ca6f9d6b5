"""The contract that every scheduling policy keeps, tried on a seeded crowd of processes."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

import msgspec

from wakeful.contracts.policy import Pick, Policy
from wakeful.facts.decisions import Mode
from wakeful.facts.processes import ProcessView
from wakeful.facts.time import NS_PER_S
from wakeful.testing.broken import require

_MODES: tuple[Mode, ...] = ("auto", "delib", "fallback")


class _Life(msgspec.Struct):
    """A process as the crowd drives it: what the policy may see, and how many steps are left until it waits or ends."""

    view: ProcessView
    left: int
    waits_after: int | None
    back_at: int | None = None


def check_policy(make: Callable[[], Policy], seed: int = 0, slots: int = 2, processes: int = 40, abandons: bool = False) -> int:
    """Drive a policy through arrivals, preemptions, waits, holds and completions, one step a second.

    Checked at every step: it picks at most ``slots`` processes, each once, and only such as can use a slot now; it abandons
    only where that is allowed; and a second policy that was told the same, calls of the same instant in another order, picks
    the same.

    Args:
        make: makes a fresh policy.
        seed: of the crowd.
        slots: how many may run at once.
        processes: how many come.
        abandons: whether it may drop processes on purpose (only experiments allow it).

    Returns:
        How many processes completed; what is left a policy may have ignored on purpose.

    Raises:
        ContractBroken: it does not keep its contract; the message says at which step.
    """
    one, other = make(), make()
    require(bool(one.name), "a policy needs a name")
    random = Random(seed)
    lives = {number: _life(number, random) for number in range(1, processes + 1)}
    eligible: set[int] = set()
    open_now: set[int] = set()
    running: tuple[int, ...] = ()
    done = 0
    for step in range(20 * processes):
        now_ns = step * NS_PER_S
        told: list[Callable[[Policy], None]] = []
        for number, life in lives.items():
            if life.view.arrived_ns == now_ns or life.back_at == step:
                life.back_at = None
                eligible.add(number)
                open_now.add(number)
                told.append(_runnable(life.view, now_ns))
        _tell(one, other, told, random)
        pick = one.pick(running, slots, now_ns)
        twin = other.pick(running, slots, now_ns)
        where = f"policy {one.name}, step {step}, seed {seed}"
        require(pick == twin, f"{where}: told the same in another order it picks {twin} instead of {pick}")
        _check_pick(pick, eligible, open_now, slots, abandons, where)
        told = []
        for number in pick.abandon:
            eligible.discard(number)
            open_now.discard(number)
            lives[number].back_at = None
            told.append(_gone(number, now_ns))
        preempted = [number for number in running if number not in pick.run and number in eligible]
        told += [_runnable(lives[number].view, now_ns) for number in preempted]
        running = tuple(number for number in pick.run if number in eligible)
        for number in running:
            life = lives[number]
            life.left -= 1
            life.view = msgspec.structs.replace(life.view, steps_done=life.view.steps_done + 1)
            if life.left <= 0:
                eligible.discard(number)
                open_now.discard(number)
                done += 1
                told.append(_gone(number, now_ns))
            elif life.waits_after == life.view.steps_done:
                eligible.discard(number)
                life.back_at = step + random.randint(1, 9)
                waits = msgspec.structs.replace(life.view, evidence_due_ns=now_ns + 10 * NS_PER_S)
                told.append(_waiting(waits, now_ns))
        running = tuple(number for number in running if number in eligible)
        _tell(one, other, told, random)
    require(done > 0, f"policy {one.name}, seed {seed}: of {processes} processes none was ever completed")
    for number in open_now:
        one.gone(number, 20 * processes * NS_PER_S)
    left = one.pick((), slots, 20 * processes * NS_PER_S)
    require(left == Pick(()), f"policy {one.name}: with every process gone it picks {left}")
    return done


def _life(number: int, random: Random) -> _Life:
    arrived_ns = random.randint(0, 30) * NS_PER_S
    needed = random.randint(1, 8)
    critical = random.random() < 0.2
    view = ProcessView(
        id=number,
        event=f"event {number}",
        treatment="description",
        mode=random.choice(_MODES),
        criticality=3 if critical else random.randint(0, 2),
        arrived_ns=arrived_ns,
        steps_done=0,
        task_relevant=random.random() < 0.5,
        priority=random.randint(0, 2),
        deadline_ns=arrived_ns + random.randint(1, 40) * NS_PER_S if critical or random.random() < 0.3 else None,
        steps_needed=needed if random.random() < 0.7 else None,
    )
    return _Life(view=view, left=needed, waits_after=random.randint(1, 4) if random.random() < 0.4 else None)


def _check_pick(pick: Pick, eligible: set[int], open_now: set[int], slots: int, abandons: bool, where: str) -> None:
    require(len(pick.run) <= slots, f"{where}: picks {len(pick.run)} for {slots} slots")
    require(len(set(pick.run)) == len(pick.run), f"{where}: picks a process twice: {pick.run}")
    wrong = [number for number in pick.run if number not in eligible]
    require(not wrong, f"{where}: picks {wrong}, which wait, are gone, or never came")
    lost = [number for number in pick.abandon if number not in open_now]
    require(not lost, f"{where}: abandons {lost}, which are gone or never came")
    require(not set(pick.run) & set(pick.abandon), f"{where}: runs what it abandons")
    require(abandons or not pick.abandon, f"{where}: abandons {pick.abandon}; only an experiment's policy may")


def _tell(one: Policy, other: Policy, told: list[Callable[[Policy], None]], random: Random) -> None:
    for say in told:
        say(one)
    for say in random.sample(told, len(told)):
        say(other)


def _runnable(view: ProcessView, now_ns: int) -> Callable[[Policy], None]:
    return lambda policy: policy.runnable(view, now_ns)


def _waiting(view: ProcessView, now_ns: int) -> Callable[[Policy], None]:
    return lambda policy: policy.waiting(view, now_ns)


def _gone(process: int, now_ns: int) -> Callable[[Policy], None]:
    return lambda policy: policy.gone(process, now_ns)

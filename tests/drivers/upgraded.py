"""A child process of test_upgrade: a mind whose treatments come in two versions, killed while processes wait, started anew."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import msgspec

from wakeful import Event, MindView, Registry, Result, treatment
from wakeful.deliberation.guidelines import GuidelineReasoner
from wakeful.domains import load
from wakeful.drivers.assembly import assemble
from wakeful.drivers.simulated import SimulatedDriver
from wakeful.facts.domain import DomainSpec, Guideline
from wakeful.facts.events import Draft
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Mark
from wakeful.facts.settings import MindSettings
from wakeful.journal import open_journal

# As a program; imported, as by the collection of tests, it does nothing.
AS_PROGRAM = __name__ == "__main__"
VERSION, JOURNAL, CALLED = (int(sys.argv[1]), Path(sys.argv[2]), Path(sys.argv[3])) if AS_PROGRAM else (2, Path(), Path())
NAMES = ("steady", "reworded", "reordered", "caller", "effector", "asker", "leaver", "parent", "unresult")


class Done(Result, frozen=True, kw_only=True, tag="done"):
    """What each of them concludes."""


class Old(Result, frozen=True, kw_only=True, tag="old"):
    """What a child concluded in version 1."""


class New(Result, frozen=True, kw_only=True, tag="new"):
    """What it concludes in version 2: the old one cannot be read as this."""

    measured: float


def done(text: str) -> Done:
    return Done(says=f"{text} by version {VERSION}", confidence=1.0)


def called(name: str) -> int:
    with CALLED.open("a") as file:
        file.write(f"{name} {VERSION}\n")
    return 1


@treatment(says="The same in both versions.")
async def steady(event: Event, mind: MindView) -> Done:
    await mind.evidence("later", "all", within_s=3600.0)
    return done("steady")


@treatment(says="Works more and says something else, but asks the same.")
async def reworded(event: Event, mind: MindView) -> Done:
    await mind.evidence("later", "all", within_s=3600.0)
    await mind.work(VERSION)
    return done(f"reworded {VERSION}")


@treatment(says="Asks for something else first in version 2.")
async def reordered(event: Event, mind: MindView) -> Done:
    if VERSION == 2:
        await mind.evidence("other", "all", within_s=1.0)
    await mind.evidence("later", "all", within_s=3600.0)
    return done("reordered")


@treatment(says="Calls outside before it waits; version 2 begins with something new.")
async def caller(event: Event, mind: MindView) -> Done:
    if VERSION == 2:
        await mind.sleep_s(0.5)
    await mind.call(lambda: called("caller"), "sensor", 5.0)
    await mind.evidence("later", "all", within_s=3600.0)
    return done("caller")


@treatment(says="Does something outside before it waits; version 2 begins with something new.")
async def effector(event: Event, mind: MindView) -> Done:
    if VERSION == 2:
        await mind.sleep_s(0.5)
    await mind.call(lambda: called("effector"), "door", 5.0, "effect")
    await mind.evidence("later", "all", within_s=3600.0)
    return done("effector")


@treatment(says="Asks with other arguments in version 2.")
async def asker(event: Event, mind: MindView) -> Done:
    await mind.evidence("later", "all", within_s=3600.0, count=VERSION)
    return done("asker")


@treatment(says="Is not there in version 2.")
async def leaver(event: Event, mind: MindView) -> Done:
    await mind.evidence("later", "all", within_s=3600.0)
    return done("leaver")


@treatment(name="child", result=Old if VERSION == 1 else New, says="A child whose result changed its type.")
async def child(event: Event, mind: MindView) -> Result:
    await mind.work()
    if VERSION == 1:
        return Old(says="old", confidence=1.0)
    return New(says="new", confidence=1.0, measured=2.0)


@treatment(says="Has a child, then waits.")
async def unresult(event: Event, mind: MindView) -> Done:
    found = await mind.treat("child", event)
    await mind.evidence("later", "all", within_s=3600.0)
    return done(f"unresult over {found.says}")


@treatment(says="Has a child that waits and is not there in version 2.")
async def parent(event: Event, mind: MindView) -> Done:
    found = await mind.treat("leaver", event)
    return done(f"parent: {found.says}")


class Versioned:
    """The plain domain, its version that of the treatments; each event is treated by the treatment of its entity's name."""

    def __init__(self) -> None:
        self._domain = load("jsonl")
        rules = tuple(Guideline(treat=name, because="it is its own", when={"entity": name}) for name in NAMES)
        own = (*NAMES, "child", "description") if VERSION == 1 else (*tuple(each.name for each in OWN), "description")
        self.spec: DomainSpec = msgspec.structs.replace(
            self._domain.spec, version=VERSION, treatments=own, guideline=rules[: len(NAMES)]
        )

    def detectors(self) -> object:
        return self._domain.detectors()

    def simulate(self, seed: int) -> None:
        return None


BOTH = (steady, reworded, reordered, caller, effector, asker, child, unresult, parent)
OWN = (*BOTH, leaver) if VERSION == 1 else BOTH


def main() -> None:
    """Version 1 ends with its own death; version 2 goes on from there."""
    domain = Versioned()
    if VERSION == 2:
        known = tuple(rule for rule in domain.spec.guideline if rule.treat != "leaver")
        domain.spec = msgspec.structs.replace(domain.spec, guideline=known)
    kernel, learner = assemble(domain, MindSettings(), registry=Registry(own=OWN, installed=()))  # type: ignore[arg-type]
    with open_journal(JOURNAL) as journal:
        driver = SimulatedDriver(kernel, journal, GuidelineReasoner(domain.spec), learner)
        driver.begin("program", "digest")
        if VERSION == 1:
            for index, name in enumerate(NAMES):
                draft = Draft(kind="alarm", entity=name, source="program", position=index, at_ns=10**18 + index)
                driver.put([draft, Mark(source="program", position=index)], draft.at_ns)
            os.kill(os.getpid(), signal.SIGKILL)
        for seconds in (2, 10, 20):
            at_ns = 10**18 + seconds * 10**9
            driver.put([Evidence(id=f"later {seconds}", topic="later", key="all", at_ns=at_ns)], at_ns)
        driver.close()


if AS_PROGRAM:
    main()

"""The sources that are heard: how far each was read, its registration memory, and the conditions that its own events raised."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from wakeful.contracts.domain import Domain, Registered
from wakeful.facts.events import Condition, Draft, Observation, Phase
from wakeful.facts.evidence import Evidence
from wakeful.facts.inputs import Begin
from wakeful.facts.lines import Finished, Opened
from wakeful.registration.registrar import CLEARED, REPEATED, SpecRegistrar
from wakeful.version import __version__


class SourceState(msgspec.Struct, kw_only=True):
    """What the kernel remembers of a source: its cursor is the last position fed.

    ``offered`` counts the events and undecodable inputs that came from it, before admission decided on them: the other side of
    received = admitted + duplicate + refused. ``joined`` counts repeats and clearings, which join their condition's process.
    ``heard_ns`` is when it was last heard; ``conditions`` are those that it raised by events of its own and has not cleared.
    """

    digest: str
    offset_ns: int
    cursor: int = -1
    observations: int = 0
    finished: bool = False
    offered: int = 0
    joined: int = 0
    heard_ns: int | None = None
    conditions: list[str] = []


class Sources:
    """Registers what each source delivers, with a registrar of its own. Its state is committed with the lines of the same feeds.

    Args:
        domain: for the registrars.
        seed: the mind's, for the record of a source's opening.
    """

    def __init__(self, domain: Domain, seed: int) -> None:
        self._domain = domain
        self._seed = seed
        self.states: dict[str, SourceState] = {}
        self._registrars: dict[str, SpecRegistrar] = {}
        self._parts: dict[str, set[str]] = {}
        self._forgotten: dict[str, bytes | None] = {}

    def begin(self, begin: Begin) -> Opened:
        """Open a source. An unfinished one goes on where it stopped; a finished or another one is read with fresh state."""
        known = self.states.get(begin.source)
        resumes = known is not None and not known.finished and known.digest == begin.digest
        if not resumes:
            for part in self._parts.pop(begin.source, ()):
                self._forgotten[_part_key(begin.source, part)] = None
            self.states[begin.source] = SourceState(
                digest=begin.digest,
                offset_ns=begin.offset_ns,
                offered=known.offered if known is not None else 0,
                joined=known.joined if known is not None else 0,
            )
            self._registrars[begin.source] = SpecRegistrar(self._domain, begin.digest)
        source = self.states[begin.source]
        if resumes and begin.offset_ns:
            source.offset_ns = begin.offset_ns
        spec = self._domain.spec
        return Opened(
            source=begin.source,
            digest=begin.digest,
            domain=spec.name,
            domain_version=spec.version,
            offset_ns=source.offset_ns,
            seed=self._seed,
            resumed_at=source.cursor + 1 if resumes else 0,
            software=__version__,
        )

    def end(self, name: str) -> Finished:
        """The source was read to its end."""
        source = self.states[name]
        source.finished = True
        return Finished(source=name, observations=source.observations)

    def hear(self, name: str, now_ns: int) -> int:
        """The source was heard now. Returns for how many ns it had not been; 0 where this is the first of it."""
        source = self.states[name]
        silent_ns = 0 if source.heard_ns is None else now_ns - source.heard_ns
        source.heard_ns = now_ns
        return silent_ns

    def observe(self, observation: Observation) -> Registered:
        """e = D(o, c) (Eq. 1): the events that it returns count as offered."""
        source = self.states[observation.source]
        source.observations += 1
        registered: Registered = self._registrars[observation.source].observe(observation)
        source.offered += len(registered.events)
        return registered

    def join(self, draft: Draft) -> Draft | Evidence | None:
        """An event that was registered elsewhere: one that repeats or clears a condition joins it, if it is known.

        Returns:
            Draft | Evidence | None: the event to cover; or the evidence that it is on its condition; or None where it clears
            what is not open, so that there is nothing to cover.
        """
        source = self.states[draft.source]
        condition = draft.condition
        known = condition is not None and condition.key in source.conditions
        if condition is not None and condition.phase in (Phase.REPEATED, Phase.CLEARED) and known:
            source.joined += 1
            if condition.phase is Phase.CLEARED:
                source.conditions.remove(condition.key)
            return _of_condition(draft, condition.key, condition.phase)
        source.offered += 1
        if condition is None:
            return draft
        if condition.phase is Phase.CLEARED:
            return None
        # A repeat of what was never raised here is the first that is heard of it: its raise was lost on the way.
        lasting = Condition(key=condition.key, phase=Phase.CHANGED if known else Phase.RAISED)
        if not known and condition.key:
            source.conditions.append(condition.key)
        return msgspec.structs.replace(draft, condition=lasting)

    # --- keyed state ---

    def changed(self) -> dict[str, bytes | None]:
        """The registration memory that changed since the last call; None for what is gone."""
        state, self._forgotten = self._forgotten, {}
        for source, registrar in self._registrars.items():
            for part, value in registrar.changed().items():
                self._parts.setdefault(source, set()).add(part)
                state[_part_key(source, part)] = value
        return state

    def restore(self, states: dict[str, SourceState], state: Mapping[str, bytes]) -> None:
        """Take up the sources' states, and the registration memory that ``changed`` gave out."""
        self.states = states
        for source, known in states.items():
            registrar = SpecRegistrar(self._domain, known.digest)
            prefix = _part_key(source, "")
            parts = {key[len(prefix) :]: value for key, value in state.items() if key.startswith(prefix)}
            registrar.restore(parts)
            self._parts[source] = set(parts)
            self._registrars[source] = registrar


def _part_key(source: str, part: str) -> str:
    return f"registration/{source}\x1f{part}"


def _of_condition(draft: Draft, key: str, phase: Phase) -> Evidence:
    """A repeat or a clearing that was offered as an event is evidence on the condition."""
    return Evidence(
        id=f"{draft.source}:{draft.position}:{draft.ordinal}:{phase}",
        topic=CLEARED if phase is Phase.CLEARED else REPEATED,
        key=key,
        at_ns=draft.at_ns,
        value=msgspec.Raw(msgspec.json.encode(draft.fields)),
    )

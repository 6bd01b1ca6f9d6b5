"""What SOURCE means: a recording, standard input, or a simulated robot; with its domain and its journal's place."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable, Iterable
from pathlib import Path

import msgspec

from wakeful.bridges import bridge_for
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import state_directory
from wakeful.contracts.bridge import Bridge, Item
from wakeful.contracts.domain import Domain
from wakeful.domains import load, names, recognise

STDIN = "-"


class Source(msgspec.Struct, frozen=True, kw_only=True):
    """A source that was found: its name and digest for the record, its domain, and its items after a position."""

    name: str
    digest: str
    domain: Domain
    items: Callable[[int], Iterable[Item]]
    total: int | None = None
    endless: bool = False


def find_source(source: str, domain: str | None, seed: int) -> Source:
    """What is to be read.

    A path that exists is a recording; otherwise a domain's name is its simulator.

    Args:
        source: a path, ``-``, or the name of a domain with a simulator.
        domain: by name or path; None: recognised from the source.
        seed: of a simulator.

    Raises:
        Mistake: it is none of these, or its domain is not recognised.
        SourceError: it cannot be read.
        DomainError: the domain cannot be used.
    """
    if domain is not None:
        load(domain)  # what is wrong with it is said before anything about the source
    path = Path(source)
    if source != STDIN and not path.exists():
        return _simulated(source, domain, seed)
    bridge = bridge_for(path)
    return _recorded(path, bridge, _domain_of(path, bridge, domain))


def _simulated(source: str, domain: str | None, seed: int) -> Source:
    simulators = [name for name in names() if load(name).simulate(seed) is not None]
    if source not in simulators:
        raise Mistake(f"there is no file {source!r}, and no simulator of that name; simulators are {', '.join(simulators)}")
    world = load(source)

    def items(after: int) -> Iterable[Item]:
        return itertools.islice(world.simulate(seed) or (), after + 1, None)

    return Source(
        name=source,
        digest=f"{source}/{world.spec.version}/{seed}",
        domain=world if domain is None else load(domain),
        items=items,
        endless=True,
    )


def _domain_of(path: Path, bridge: Bridge, domain: str | None) -> Domain:
    if domain is not None:
        return load(domain)
    if str(path) == STDIN:
        raise Mistake(f"what comes from standard input has no domain of its own: name it with --domain ({', '.join(names())})")
    found = recognise(bridge.peek(path), path)
    if found is None:
        raise Mistake(
            f"no domain recognises {path}: name one with --domain ({', '.join(names())}), "
            f"or draft one with 'wakeful new domain --from {path}'"
        )
    return load(found)


def _recorded(path: Path, bridge: Bridge, domain: Domain) -> Source:
    piped = str(path) == STDIN
    total = None if piped else bridge.peek(path).items
    return Source(
        # The name without its folder: another spelling of the same path goes on where it stopped; the digest tells files apart.
        name=STDIN if piped else path.resolve().name,
        digest=bridge.digest(path),
        domain=domain,
        items=lambda after: bridge.read(path, after),
        total=total,
    )


def default_journal(source: Source) -> Path:
    """The journal of a source that was given none: by its name and digest in the state directory."""
    stem = "".join(letter if letter.isalnum() or letter in "-_" else "_" for letter in Path(source.name).stem)[:40]
    digest = hashlib.blake2b(f"{source.digest}/{source.domain.spec.name}".encode(), digest_size=6).hexdigest()
    return state_directory() / f"{stem or 'stdin'}-{digest}.db"

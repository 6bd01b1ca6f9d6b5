"""Domains: one robot family's vocabulary each, found by name, by path, by entry point, or recognised from a source.

A domain is a package beside this file: ``domain.toml`` (its data), and only where data cannot say it ``detectors.py``
(with ``DETECTORS: dict[str, DetectorFactory]``) and ``simulate.py`` (with ``simulate(seed) -> Iterator[Observation]``).
Others come from the entry-point group ``wakeful.domains`` (a package like that, or a Domain) or from a user's path:
a TOML file, or a folder that holds ``domain.toml`` and perhaps those two files.
"""

from __future__ import annotations

import logging
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType

from wakeful.contracts.bridge import Peek
from wakeful.contracts.domain import Domain, DomainError
from wakeful.domains.package import PackageDomain
from wakeful.domains.recognition import score
from wakeful.domains.toml import read_spec
from wakeful.facts.domain import DomainSpec

__all__ = ["GROUP", "DomainError", "load", "names", "recognise"]

GROUP = "wakeful.domains"
_HERE = Path(__file__).parent
_log = logging.getLogger(__name__)


def names() -> tuple[str, ...]:
    """Every domain that can be loaded by name, sorted: built in, or installed under the entry-point group."""
    return tuple(sorted({*_built_in(), *_installed()}))


def load(name: str) -> Domain:
    """The domain called ``name``, or at the path ``name`` (a ``.toml`` file or a folder with ``domain.toml``).

    Raises:
        DomainError: there is none of that name, or it cannot be used. The message lists the names, or says where it is wrong.
    """
    built_in = _built_in()
    if name in built_in:
        return PackageDomain.of_folder(built_in[name], f"{__name__}.{name}")
    if name in (installed := _installed()):
        return _of_entry_point(installed[name])
    path = Path(name)
    if path.is_dir():
        return PackageDomain.of_folder(path)
    if path.suffix == ".toml" or path.is_file():
        return PackageDomain(read_spec(path))
    raise DomainError(f"no domain {name!r}; use one of {', '.join(names())}, or the path of a domain's TOML file")


def recognise(peek: Peek, path: Path) -> str | None:
    """The domain that a source looks like most, or None.

    A domain is in question when all that its ``recognise`` table declares holds: one of its bridges, one of its suffixes,
    each of its channel patterns. Among those, the one with more channel patterns is closer, then suffix, then bridge;
    equal ones go by name. A domain that cannot be loaded is passed over with a warning: it must not stop the others.
    """
    found: list[tuple[int, str]] = []
    for name in names():
        try:
            spec = load(name).spec
        except DomainError as error:
            _log.warning("domain %s is passed over: %s", name, error)
            continue
        if points := score(spec.recognise, peek, path):
            found.append((-points, name))
    return min(found)[1] if found else None


def _built_in() -> dict[str, Path]:
    return {folder.name: folder for folder in sorted(_HERE.iterdir()) if (folder / "domain.toml").is_file()}


def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=GROUP)}


def _of_entry_point(point: EntryPoint) -> Domain:
    try:
        loaded = point.load()
    except Exception as error:  # a third party's import may fail in any way; the error names it
        raise DomainError(f"domain {point.name} ({point.value}) cannot be imported: {error!r}; reinstall its package") from error
    if isinstance(loaded, ModuleType):
        if loaded.__file__ is None:
            raise DomainError(
                f"domain {point.name}: {point.value} is no package with a folder; add an __init__.py beside domain.toml"
            )
        return PackageDomain.of_folder(Path(loaded.__file__).parent, loaded.__name__)
    made: Domain = loaded() if isinstance(loaded, type) else loaded
    if not isinstance(getattr(made, "spec", None), DomainSpec):
        raise DomainError(f"domain {point.name}: {point.value} is no Domain (no `spec`); see wakeful.contracts.domain")
    return made

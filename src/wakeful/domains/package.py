"""A domain made of files: its TOML, and the two Python modules that data cannot replace."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

from wakeful.contracts.detector import DetectorFactory
from wakeful.contracts.domain import DomainError
from wakeful.domains.toml import read_spec
from wakeful.facts.domain import DomainSpec
from wakeful.facts.events import Observation

Simulate = Callable[[int], Iterator[Observation]]

_NONE: Mapping[str, DetectorFactory] = MappingProxyType({})


class PackageDomain:
    """A Domain: its data, its own detectors, and its simulator where there is one."""

    def __init__(
        self, spec: DomainSpec, detectors: Mapping[str, DetectorFactory] = _NONE, simulate: Simulate | None = None
    ) -> None:
        self._spec = spec
        self._detectors = detectors
        self._simulate = simulate

    @classmethod
    def of_folder(cls, folder: Path, module: str = "") -> PackageDomain:
        """The domain in a folder. ``module`` is its importable name; without one its Python files are loaded by path.

        Raises:
            DomainError: no usable ``domain.toml``, or a Python file of it that lacks what it must define or does not import.
        """
        spec = read_spec(folder / "domain.toml")
        detectors: Mapping[str, DetectorFactory] = _NONE
        simulate: Simulate | None = None
        if (path := folder / "detectors.py").is_file():
            own = getattr(_module(path, module), "DETECTORS", None)
            if not isinstance(own, Mapping) or not all(callable(factory) for factory in own.values()):
                raise DomainError(f"{path}: must define DETECTORS, a dict of detector factories by name")
            detectors = own
        if (path := folder / "simulate.py").is_file():
            simulate = getattr(_module(path, module), "simulate", None)
            if not callable(simulate):
                raise DomainError(f"{path}: must define simulate(seed), an endless source of observations")
        return cls(spec, detectors, simulate)

    @property
    def spec(self) -> DomainSpec:
        """The domain's data."""
        return self._spec

    def detectors(self) -> Mapping[str, DetectorFactory]:
        """The domain's own detectors by name."""
        return self._detectors

    def simulate(self, seed: int) -> Iterator[Observation] | None:
        """An endless, seeded source of this domain, or None where there is none."""
        return None if self._simulate is None else self._simulate(seed)


def _module(path: Path, package: str) -> ModuleType:
    name = f"{package}.{path.stem}" if package else f"_wakeful_domain_{path.resolve().parent.name}_{path.stem}"
    try:
        if package:
            return importlib.import_module(name)
        found = importlib.util.spec_from_file_location(name, path)
        if found is None or found.loader is None:
            raise DomainError(f"{path}: is no Python file; rename or remove it")
        made = importlib.util.module_from_spec(found)
        sys.modules[name] = made
        found.loader.exec_module(made)
    except DomainError:
        raise
    except Exception as error:  # a domain author's code may fail in any way; the error names the file
        raise DomainError(f"{path}: does not import ({error!r}); correct it") from error
    return made

"""Where treatments are found by name: the built-in ones, a user's own, and those of installed packages."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from types import MappingProxyType

from wakeful.contracts.treatment import Treatment
from wakeful.facts.results import Result
from wakeful.treatments.analogy import analogy
from wakeful.treatments.causal_analysis import causal_analysis
from wakeful.treatments.comparison import comparison
from wakeful.treatments.decorator import TreatmentError
from wakeful.treatments.description import description
from wakeful.treatments.diagnosis import diagnosis
from wakeful.treatments.memory import memory
from wakeful.treatments.planning import planning
from wakeful.treatments.risk_prediction import risk_prediction

GROUP = "wakeful.treatments"
"""The entry-point group: its names are free, its objects are Treatments."""

BUILT_IN: tuple[Treatment, ...] = (
    description,
    memory,
    risk_prediction,
    planning,
    diagnosis,
    analogy,
    comparison,
    causal_analysis,
)


class Registry:
    """The treatments that may be chosen, by name, in the order in which they came.

    Args:
        own: a user's own treatments, after the built-in ones.
        installed: the entry points to load; those of the group ``wakeful.treatments`` if not given.

    An installed package whose treatment does not load takes nothing else with it: ``broken`` says which and why, and ``get``
    repeats it.

    >>> Registry(installed=()).names()[:3]
    ('description', 'memory', 'risk_prediction')
    """

    def __init__(self, own: Iterable[Treatment] = (), installed: Iterable[EntryPoint] | None = None) -> None:
        self._by_name: dict[str, Treatment] = {each.name: each for each in BUILT_IN}
        self._broken: dict[str, str] = {}
        found = entry_points(group=GROUP) if installed is None else installed
        for point in sorted(found, key=lambda each: (each.name, each.value)):
            self._load(point)
        for each in own:
            self.add(each)

    @property
    def broken(self) -> Mapping[str, str]:
        """Entry points that gave no treatment, and why."""
        return MappingProxyType(self._broken)

    def names(self) -> tuple[str, ...]:
        """The names of all treatments."""
        return tuple(self._by_name)

    def get(self, name: str) -> Treatment:
        """The treatment of that name.

        Raises:
            TreatmentError: there is none; the message lists those that there are.
        """
        try:
            return self._by_name[name]
        except KeyError:
            pass
        why = f" (its entry point is broken: {self._broken[name]})" if name in self._broken else ""
        raise TreatmentError(f"no treatment {name!r}{why}; there are {', '.join(self._by_name)}")

    def add(self, treatment: Treatment, replace: bool = False) -> None:
        """Take in a treatment. ``replace`` lets it stand in for one of the same name, a built-in one too.

        Raises:
            TreatmentError: it is no treatment, or its name is taken; nothing has changed.
        """
        problem = _problem(treatment)
        if problem:
            raise TreatmentError(problem)
        if treatment.name in self._by_name and not replace:
            raise TreatmentError(f"treatment {treatment.name}: the name is taken; choose another, or pass replace=True")
        self._by_name[treatment.name] = treatment

    def _load(self, point: EntryPoint) -> None:
        try:
            self.add(point.load())
        except TreatmentError as error:
            self._broken[point.name] = str(error)
        except Exception as error:  # a third party's import may fail in any way; it is kept and shown, not hidden
            self._broken[point.name] = f"{point.value} does not load: {error!r}"


def _problem(candidate: object) -> str:
    """What keeps an object from being a treatment, or nothing."""
    if isinstance(candidate, type):
        return f"{candidate.__qualname__} is a class: register an instance of it"
    for name, kind in (("name", str), ("version", int), ("says", str)):
        if not isinstance(getattr(candidate, name, None), kind):
            return f"{candidate!r} is no treatment: it has no {name}; make one with @wakeful.treatment"
    result = getattr(candidate, "result", None)
    if not (isinstance(result, type) and issubclass(result, Result)) or not callable(getattr(candidate, "treat", None)):
        return f"treatment {getattr(candidate, 'name', '')}: needs a result type and a coroutine method treat(event, mind)"
    return ""

"""Minimal diagnoses: the smallest sets of faults that explain all that is seen, for devices composed of parts.

An extra (`pip install 'wakeful[diagnosis]'`): answer sets of a small logic program, enumerated subset-minimal by clingo. Source:
abductive diagnosis, Reiter 1987 and Console and Torasso 1991; Gebser, Kaufmann and Schaub 2012 for the enumeration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

from wakeful.contracts.treatment import Refusal
from wakeful.facts.domain import Fault
from wakeful.facts.values import Fact

#: A fault explains what it causes at least so often, and is excluded where something is missing that it all but always causes.
EXPLAINS, ALWAYS = 0.3, 0.95

_PROGRAM = """
{ present(F) } :- fault(F).
:- seen(S), not explained(S).
explained(S) :- present(F), explains(F, S).
:- missing(S), present(F), always(F, S).
#show present/1.
"""

#: Subset-minimal models only: falsify `present` first, and record what was found as a lower bound.
_MINIMAL = ("0", "--heuristic=Domain", "--enum-mode=domRec", "--dom-mod=5,16", "--warn=none", "--parallel-mode=1")


class MissingClingo(Refusal):
    """clingo is not installed; the message names the extra."""


class MinimalDiagnosis(Fact, frozen=True):
    """Faults that together explain every sign, none of which can be left out. ``weight``: the product of their priors' odds."""

    faults: tuple[str, ...]
    weight: float


def minimal_diagnoses(
    faults: Sequence[Fault], known: Mapping[str, bool], limit: int = 8, within_s: float = 0.5
) -> tuple[MinimalDiagnosis, ...]:
    """The minimal diagnoses, the likeliest first.

    Args:
        faults: the fault table.
        known: symptoms seen (True), or looked for and not there (False).
        limit: at most so many are given.
        within_s: the search is broken off after so long: then none is given, since those found might not be the likeliest.

    Returns:
        Sets of faults, by falling weight, then by name. Empty where nothing is seen, or something seen can't be explained.

    Raises:
        MissingClingo: clingo is not installed.
    """
    try:
        import clingo  # noqa: PLC0415
    except ImportError as error:
        raise MissingClingo("minimal diagnoses need clingo: pip install 'wakeful[diagnosis]'") from error
    seen = [symptom for symptom, there in known.items() if there and _explainable(faults, symptom)]
    if not seen:
        return ()
    control = clingo.Control(list(_MINIMAL))
    control.add("base", [], _PROGRAM + _facts(faults, seen, known))
    control.ground([("base", [])])
    found: list[tuple[int, ...]] = []
    with control.solve(on_model=lambda model: found.append(_present(model.symbols(shown=True))), async_=True) as handle:
        if not handle.wait(within_s):
            handle.cancel()
            return ()
    diagnoses = [
        MinimalDiagnosis(
            faults=tuple(sorted(faults[place].name for place in places)),
            weight=float(f"{prod(_odds(faults[place].prior) for place in places):.6g}"),
        )
        for places in set(found)
    ]
    return tuple(sorted(diagnoses, key=lambda each: (-each.weight, each.faults))[:limit])


def _explainable(faults: Sequence[Fault], symptom: str) -> bool:
    return any(fault.causes.get(symptom, 0.0) >= EXPLAINS for fault in faults)


def _facts(faults: Sequence[Fault], seen: Sequence[str], known: Mapping[str, bool]) -> str:
    """Faults and symptoms by number: names come from domains and would have to be quoted."""
    missing = [symptom for symptom, there in known.items() if not there]
    lines = [f"fault({place})." for place in range(len(faults))]
    lines += [f"seen({number})." for number in range(len(seen))]
    lines += [f"missing({len(seen) + number})." for number in range(len(missing))]
    for place, fault in enumerate(faults):
        lines += [f"explains({place},{n})." for n, symptom in enumerate(seen) if fault.causes.get(symptom, 0.0) >= EXPLAINS]
        lines += [
            f"always({place},{len(seen) + n})." for n, symptom in enumerate(missing) if fault.causes.get(symptom, 0.0) >= ALWAYS
        ]
    return "\n".join(lines)


def _present(symbols: Sequence[object]) -> tuple[int, ...]:
    return tuple(sorted(symbol.arguments[0].number for symbol in symbols))  # type: ignore[attr-defined]


def _odds(prior: float) -> float:
    share = min(max(prior, 1e-6), 1.0 - 1e-6)
    return share / (1.0 - share)

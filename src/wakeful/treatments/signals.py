"""How far recorded signals are from breaking a rule: robustness of a formula of signal temporal logic over an event's traces.

An extra (`pip install 'wakeful[signals]'`, rtamt). Source: Maler and Nickovic 2004 for the logic; Fainekos and Pappas 2009 and
Donzé and Maler 2010 for its robust semantics.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING

from wakeful.contracts.treatment import Refusal
from wakeful.facts.values import Field
from wakeful.treatments.measures import significant

if TYPE_CHECKING:
    import rtamt

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_WORDS = frozenset(
    [
        "always",
        "eventually",
        "historically",
        "once",
        "until",
        "since",
        "next",
        "prev",
        "not",
        "and",
        "or",
        "implies",
        "iff",
        "xor",
        "rise",
        "fall",
        "abs",
        "sqrt",
        "exp",
        "pow",
        "true",
        "false",
    ]
)


class SignalError(Refusal):
    """The formula cannot be read, or rtamt is not installed. The message says which, and what to do."""


def margin(formula: str, fields: Mapping[str, Field]) -> float | None:
    """How far the traces are from breaking the formula, in the signal's own unit; below zero they break it.

    Args:
        formula: such as ``always[0:5](force_n < 40)``; times in samples, variables are vector fields of the event.
        fields: the event's; numbers stand for a signal that does not change.

    Returns:
        the robustness at the first sample, rounded; None where the event lacks one of the formula's signals.

    Raises:
        SignalError: the formula is wrong, or rtamt is missing.
    """
    names = tuple(dict.fromkeys(name for name in _NAME.findall(formula) if name not in _WORDS))
    traces = {name: fields[name] for name in names if isinstance(fields.get(name), tuple)}
    if not names or not traces or any(name not in fields for name in names):
        return None
    length = min(len(trace) for trace in traces.values() if isinstance(trace, tuple))
    if not length:
        return None
    data: dict[str, list[float]] = {"time": [float(at) for at in range(length)]}
    for name in names:
        value = fields[name]
        if isinstance(value, tuple):
            data[name] = [float(each) for each in value[:length]]
        elif isinstance(value, int | float):
            data[name] = [float(value)] * length
        else:
            return None
    return significant(float(_read(formula, names).evaluate(data)[0][1]))


@lru_cache(maxsize=64)
def _read(formula: str, names: tuple[str, ...]) -> rtamt.StlDiscreteTimeSpecification:
    try:
        import rtamt  # noqa: PLC0415
    except ImportError as error:
        raise SignalError("rules on signals need rtamt: pip install 'wakeful[signals]'") from error
    specification = rtamt.StlDiscreteTimeSpecification()
    for name in names:
        specification.declare_var(name, "float")
    specification.spec = formula
    try:
        specification.parse()
    except rtamt.RTAMTException as error:
        raise SignalError(f"the rule {formula!r} cannot be read as signal temporal logic: {error}") from error
    return specification

"""The figures at the head of the page: is everything attended to, and how."""

from __future__ import annotations

from wakeful.journal.views import Summary
from wakeful.journal.wording.words import count, duration, percent
from wakeful.web.markup import Child, Markup, element, join, text

MODE_WORDS = {"auto": "automatic", "delib": "deliberated", "fallback": "fallback"}
_WIDTH = 200


def figures(told: Summary) -> Markup:
    """Coverage, completion, intake, debt, automatic share and results, each with what it is made of."""
    result = told.accuracy.result
    base = f"always “{told.accuracy.base_label}”: {percent(told.accuracy.base_rate.fraction)}" if result.of else "no verdict yet"
    completions = ", ".join(f"{number:,} {name}" for name, number in told.completions.items())
    treated = ", ".join(f"{name} within {duration(seconds)}" for name, seconds in sorted(told.first_treatment_s.items()))
    return element(
        "dl",
        _figure(
            "Coverage",
            percent(told.coverage),
            f"{told.uncovered:,} uncovered" if told.uncovered else "no admitted event is unattended",
            bad=told.uncovered > 0,
        ),
        _figure("Completion", percent(told.completion), completions or "nothing has ended yet"),
        _figure(
            "Received",
            f"{told.received:,}",
            f"= {told.admitted:,} admitted + {told.duplicate:,} duplicate + {told.refused:,} refused",
        ),
        _figure(
            "Debt",
            f"{told.debt:,}",
            element("a", "owed a better treatment", href="/?only=debt") if told.debt else "nothing is owed a better treatment",
            bad=told.debt > 0,
        ),
        _figure(
            "Automatic",
            percent(told.modes.get("auto", 0) / told.admitted if told.admitted else None),
            join(
                _shares(told),
                ", ".join(f"{told.modes[mode]:,} {words}" for mode, words in MODE_WORDS.items() if mode in told.modes),
            ),
        ),
        _figure("Results right", percent(result.fraction), f"of {result.of:,}; {base}"),
        _figure("First treatment", treated.split(",")[0].split(" within ")[-1] if treated else "–", _waits(treated, told)),
        class_="figures",
    )


def _waits(treated: str, told: Summary) -> str:
    return f"longest: {treated or 'none yet'}; {count(told.expired_waits, 'wait')} expired"


def _figure(name: str, value: str, says: Child, bad: bool = False) -> Markup:
    # A percentage breaks no line before its sign.
    told = says if isinstance(says, Markup) else Markup(text(says).replace(" %", "&nbsp;%"))
    return element(
        "div",
        element("dt", name),
        element("dd", value, class_="value"),
        element("dd", told),
        class_="bad" if bad else None,
    )


def _shares(told: Summary) -> Markup:
    """The modes' shares as one bar; the words beside it say the same."""
    parts: list[Markup] = []
    start = 0.0
    for mode in MODE_WORDS:
        width = _WIDTH * told.modes.get(mode, 0) / told.admitted if told.admitted else 0.0
        parts.append(element("rect", x=f"{start:.1f}", y=0, width=f"{width:.1f}", height=8, class_=f"mode-{mode}"))
        start += width
    return element("svg", *parts, viewBox=f"0 0 {_WIDTH} 8", preserveAspectRatio="none", class_="shares", aria_hidden="true")

"""Why a treatment was chosen and how it was executed: candidates as bars, the gate's numbers, reasons, what it rests on."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.journal.story import ProcessStory, Remembered
from wakeful.journal.views import History, Story
from wakeful.journal.wording.decisions import MODES, gate_lines, memory_words, model_words
from wakeful.journal.wording.words import count
from wakeful.web.address import address
from wakeful.web.markup import Child, Markup, clean, element, join

Weigh = Callable[[Event, Decision], Sequence[tuple[str, float]]]
"""What weighed most in a decision, as words with signed weights, the strongest first; empty where nothing can be said."""

_SHOWN = 6
_LONGEST = 1_000
_BAR = 100


def decision(read: History, told: Story, process: ProcessStory, weigh: Weigh) -> Markup:
    """The first decision in full, and what later ones changed."""
    if not process.decisions:
        return element("p", "None: this process is uncovered.", class_="bad")
    first = process.decisions[0]
    chosen = element("p", element("strong", first.treatment), f", {MODES[first.mode]}; {model_words(read, first)}")
    later = [_change(earlier, after) for earlier, after in zip(process.decisions, process.decisions[1:], strict=False)]
    if process.role == "child":
        return join(chosen, _list(first.reasons))
    found = [memory for memory in told.rests_on if memory.experience.id in first.rests_on]
    return join(
        chosen,
        _candidates(first),
        *later,
        _titled("Automatic only if", _gate(first)),
        _titled("Reasons", _list(first.reasons)) if first.reasons else None,
        _weights(weigh(told.event, first)),
        _titled(
            "Nearest validated experience",
            element("ul", *(element("li", _memory(memory)) for memory in found)),
        )
        if found
        else None,
    )


def _titled(title: str, *content: Child) -> Markup:
    return join(element("h4", title), *content)


def _list(lines: Sequence[str]) -> Markup:
    return element("ul", *(element("li", clean(line, _LONGEST)) for line in lines))


def _candidates(decided: Decision) -> Markup:
    """The treatments that were considered, each with a bar as long as its probability."""
    shown = [(each.treatment, each.probability) for each in decided.candidates[:_SHOWN]]
    rest = decided.candidates[_SHOWN:]
    if rest:
        shown.append((count(len(rest), "other"), sum(each.probability for each in rest)))
    return element(
        "table",
        element("caption", "Candidates", class_="unseen"),
        element(
            "tbody",
            *(
                element(
                    "tr",
                    element("th", treatment, scope="row"),
                    element("td", f"{probability:.3f}"),
                    element("td", _bar(probability), aria_hidden="true", class_="bar"),
                    class_="chosen" if treatment == decided.treatment else None,
                )
                for treatment, probability in shown
            ),
        ),
        class_="candidates",
    )


def _bar(share: float) -> Markup:
    length = _BAR * min(1.0, max(0.0, share))
    return element(
        "svg",
        element("rect", width=_BAR, height=8, class_="room"),
        element("rect", width=f"{length:.1f}", height=8, class_="fill"),
        viewBox=f"0 0 {_BAR} 8",
        preserveAspectRatio="none",
    )


def _gate(decided: Decision) -> Markup:
    return element(
        "ul",
        *(
            element("li", element("span", "yes" if holds else "no", class_="yes" if holds else "no"), f" {says}")
            for says, holds in gate_lines(decided.gate, decided.audit)
        ),
        class_="gate",
    )


def _memory(memory: Remembered) -> Markup:
    experience = memory.experience
    says = memory_words(memory).removeprefix(f"{experience.id}: ")
    return join(element("a", f"experience {experience.id}", href=address(experience.event)), f": {clean(says, _LONGEST)}")


def _weights(weights: Sequence[tuple[str, float]]) -> Markup | None:
    if not weights:
        return None
    return _titled(
        "What weighed most, against what is typical",
        element(
            "ul",
            *(
                element("li", element("span", f"{weight:+.2f}", class_="yes" if weight > 0 else "no"), f" {clean(says, 200)}")
                for says, weight in weights
            ),
            class_="gate",
        ),
    )


def _change(earlier: Decision, later: Decision) -> Markup:
    """What a later decision changed: the reasoner's answer, or a failure that led to fallback."""
    same = (earlier.treatment, earlier.mode) == (later.treatment, later.mode)
    what = f"confirmed {later.treatment}" if same else f"changed to {later.treatment}, {MODES[later.mode]}"
    before = len(earlier.reasons)
    added = later.reasons[before:] if later.reasons[:before] == earlier.reasons else later.reasons
    return _titled(f"Then {what}, confidence {later.confidence:.2f}", _list(added))

"""The page of one event: its story, from what was met to what the world showed since."""

from __future__ import annotations

from wakeful.facts.time import to_s
from wakeful.journal.story import ProcessStory
from wakeful.journal.views import History, Story
from wakeful.journal.wording.events import event_rows, role_words
from wakeful.journal.wording.timeline import timeline
from wakeful.journal.wording.verdicts import lesson_words, verdict_words
from wakeful.journal.wording.words import count, duration
from wakeful.web.address import name_of
from wakeful.web.decided import Weigh, decision
from wakeful.web.markup import Markup, clean, element, join
from wakeful.web.now import grade
from wakeful.web.result import result
from wakeful.web.stream import chips

_LONGEST = 4_000
_FIRST, _LAST = 30, 10
"""Of a long timeline so many entries from the beginning and from the end are shown."""


def why(read: History, told: Story, weigh: Weigh) -> Markup:
    """All that the journal tells of one event."""
    return join(
        element("section", element("h2", "What was met"), _rows(event_rows(told)), class_="card"),
        *(_process(read, told, process, weigh) for process in told.processes),
        _trust(told),
        _models(told),
    )


def title(told: Story) -> Markup:
    """The event's name, its sentence, and how it stands."""
    event = told.event
    root = next((process for process in told.processes if process.role == "root"), None)
    judged = root.verdicts[-1].judged.verdict.value if root and root.verdicts else ""
    mode = root.decisions[-1].mode if root and root.decisions else ""
    return join(
        element("h1", name_of(event.kind, event.entity or event.robot)),
        element("p", clean(event.says, _LONGEST), class_="lead") if event.says else None,
        element(
            "p",
            grade(event.criticality),
            chips(root.treatment if root else "", mode, (root.end or root.state) if root else "uncovered", judged),
            class_="chips",
        ),
    )


def _process(read: History, told: Story, process: ProcessStory, weigh: Weigh) -> Markup:
    heading = f"Process {process.id}" if process.role == "root" else role_words(process)
    return element(
        "article",
        element("h2", heading),
        element("p", f"because {clean(process.because, _LONGEST)}") if process.because else None,
        element(
            "div",
            element("section", element("h3", "What it concluded"), result(read, told, process), class_="card"),
            element(
                "div",
                _since(told, process),
                element(
                    "section", element("h3", "Why this treatment, and how"), decision(read, told, process, weigh), class_="card"
                ),
                class_="stack",
            ),
            class_="columns",
        ),
        element("section", element("h3", "How it thought"), _thinking(read, told, process), class_="card"),
        class_=f"process {process.role}",
        id=f"process-{process.id}",
    )


def _rows(rows: list[tuple[str, str]]) -> Markup:
    return element(
        "dl",
        *(join(element("dt", name), element("dd", clean(text, _LONGEST))) for name, text in rows if text),
        class_="rows",
    )


def _thinking(read: History, told: Story, process: ProcessStory) -> Markup:
    entries = timeline(read, process.trail)
    left_out = len(entries) - _FIRST - _LAST
    items = [
        element("li", element("span", f"+{duration(to_s(at_ns - told.admitted_ns))}", class_="when"), element("span", says))
        for at_ns, says in (entries if left_out <= 0 else entries[:_FIRST] + entries[-_LAST:])
    ]
    if left_out > 0:
        items.insert(
            _FIRST,
            element("li", element("span", "…", class_="when"), element("span", count(left_out, "more entry", "more entries"))),
        )
    if process.state != "completed":
        held = f", held by {process.held_by}" if process.held_by else ""
        items.append(element("li", element("span", "now", class_="when"), element("strong", f"{process.state}{held}")))
    items.extend(
        element("li", element("span", "note", class_="when"), element("span", clean(f"{note.what}: {note.detail}", _LONGEST)))
        for note in process.notes
    )
    return element("ol", *items, class_="timeline") if items else element("p", "It has not begun.", class_="calm")


def _since(told: Story, process: ProcessStory) -> Markup | None:
    """The outcomes and verdicts on the result, and what was learned from them."""
    if process.role == "child" or not process.forecast:
        return None
    lines = [
        element("li", verdict_words(told, process, verdict), class_=verdict.judged.verdict.value) for verdict in process.verdicts
    ]
    if not lines:
        left_s = to_s((process.closes_ns or told.now_ns) - told.now_ns)
        says = f"Nothing yet: the window closes in {duration(left_s)}." if left_s > 0 else "Nothing that decides it."
        lines = [element("li", says)]
    lines += [
        element("li", f"learned from as experience {experience.id}: {lesson_words(process, experience)}")
        for experience in told.experiences
        if experience.process == process.id
    ]
    return element("section", element("h3", "What happened since"), element("ul", *lines, class_="since"), class_="card")


def _trust(told: Story) -> Markup | None:
    if not told.trust:
        return None
    lines = (
        element("li", f"{each.trusted.treatment} {each.trusted.before:.3f} → {each.trusted.after:.3f}: {each.trusted.why}")
        for each in told.trust
    )
    return element("section", element("h2", "Trust that it changed"), element("ul", *lines), class_="card")


def _models(told: Story) -> Markup | None:
    if not told.lineage:
        return None
    head = element(
        "tr", *(element("th", name, scope="col") for name in ("Version", "From", "Experiences", "Held back", "Right", "Why"))
    )
    rows = (
        element(
            "tr",
            element("th", card.version, scope="row"),
            element("td", card.base or "guidelines"),
            element("td", f"{card.watermark:,}"),
            element("td", f"{card.held_back:,}"),
            element("td", "–" if card.challenger_accuracy is None else f"{card.challenger_accuracy:.0%}"),
            element("td", clean(card.why, 200)),
        )
        for card in told.lineage
    )
    return element(
        "section",
        element("h2", "Model lineage"),
        element(
            "details",
            element("summary", f"Version {told.lineage[0].version} and what it came from", id="lineage"),
            element("div", element("table", element("thead", head), element("tbody", *rows)), class_="scroll"),
        ),
        class_="card",
    )

"""The pages, made of a history: the overview, one event, and what is said where there is none."""

from __future__ import annotations

from wakeful.journal.views import History, NoSuchEvent, find_event, story, summary_of
from wakeful.web.address import address, name_of
from wakeful.web.asked import Asked, form
from wakeful.web.curve import curve
from wakeful.web.decided import Weigh
from wakeful.web.figures import figures
from wakeful.web.markup import clean, element, join
from wakeful.web.now import now
from wakeful.web.shell import Document, section, source
from wakeful.web.stream import strange, stream
from wakeful.web.why import title, why

_STRANGE = 3


def overview(read: History, written_s: float, asked: Asked) -> Document:
    """What the robots are thinking about, and how it has gone."""
    told = summary_of(read, _STRANGE)
    parts = {
        "source": source(read, written_s),
        "figures": figures(told),
        "now": now(read),
        "events": stream(read, asked),
        "curve": curve(told.curve),
        "strange": strange(told.strangest),
    }
    heading = "Events like that" if asked.any else "Latest events" if not asked.before else "Earlier events"
    body = join(
        element("h1", "What is being thought about, and why", class_="unseen"),
        element("div", parts["figures"], id="figures"),
        section("now", "Now", parts["now"]),
        element(
            "div",
            element(
                "section",
                element("h2", heading, id="events-title"),
                form(asked, read),
                element("div", parts["events"], id="events"),
                class_="card",
                aria_labelledby="events-title",
            ),
            element(
                "div",
                section("curve", "Learning", parts["curve"]),
                section("strange", "Strangest so far", parts["strange"]),
                class_="stack",
            ),
            class_="columns wide",
        ),
    )
    return Document(title="Now", parts=parts, body=body, position=read.last, live=f"/live{asked.query()}")


def event(read: History, written_s: float, prefix: str, weigh: Weigh) -> Document:
    """The story of one event.

    Raises:
        NoSuchEvent: none has that id or that beginning of an id, or several do.
    """
    told = story(read, find_event(read, prefix))
    parts = {"source": source(read, written_s), "title": title(told), "why": why(read, told, weigh)}
    body = join(
        element("nav", element("a", "← All events", href="/"), aria_label="Back", class_="back"),
        element("div", parts["title"], id="title", class_="title"),
        element("div", parts["why"], id="why"),
    )
    name = name_of(told.event.kind, told.event.entity)
    return Document(title=name, parts=parts, body=body, position=read.last, live=f"{address(told.event.id)}/live")


def nothing(read: History, written_s: float, error: NoSuchEvent) -> Document:
    """What is said where no event has that id, with those that were meant, perhaps."""
    close = [
        element(
            "li",
            element("a", name_of(past.event.kind, past.event.entity), href=address(each)),
            f" {each[:10]}",
        )
        for each in error.close
        if (past := read.events.get(each))
    ]
    body = join(
        element("h1", "There is no such event"),
        element("p", f"{clean(str(error), 200)}."),
        join(element("p", "Perhaps one of these was meant:"), element("ul", *close)) if close else None,
        element("p", element("a", "All events", href="/")),
    )
    return Document(title="No such event", parts={"source": source(read, written_s)}, body=body)


def trouble(says: str) -> Document:
    """What is said where the journal cannot be read."""
    body = join(
        element("h1", "The journal cannot be read"),
        element("p", clean(says, 500)),
        element("p", element("a", "Try again", href="/")),
    )
    return Document(title="No journal", parts={}, body=body)


def no_page() -> Document:
    """What is said under an address that is none of ours."""
    body = join(element("h1", "There is no such page"), element("p", element("a", "All events", href="/")))
    return Document(title="No such page", parts={}, body=body)

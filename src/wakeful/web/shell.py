"""The document around every page: head, banner, and the place where what is live is said."""

from __future__ import annotations

from datetime import UTC, datetime

import msgspec

from wakeful.journal.views import History
from wakeful.journal.wording.words import count
from wakeful.version import __version__
from wakeful.web.markup import Markup, clean, element, join


class Document(msgspec.Struct, frozen=True, kw_only=True):
    """One page: its parts by the id under which each is replaced when the journal grows."""

    title: str
    parts: dict[str, Markup]
    body: Markup
    """The parts where they stand."""
    position: int = 0
    live: str = ""
    """Where its changes are streamed; empty for a page that never changes."""


def section(identity: str, title: str, content: Markup, class_: str = "card") -> Markup:
    """A titled part of a page that is replaced as a whole."""
    return element(
        "section",
        element("h2", title, id=f"{identity}-title"),
        element("div", content, id=identity),
        class_=class_,
        aria_labelledby=f"{identity}-title",
    )


def source(read: History, written_s: float) -> Markup:
    """Which source the journal is of, how far it goes, and when it was last written."""
    sources = {opened.source: opened for opened in read.opened}
    names = ", ".join(f"{clean(name, 60)} ({clean(opened.domain, 40)})" for name, opened in list(sources.items())[-2:])
    if len(sources) > 2:
        names = f"{count(len(sources) - 2, 'source')} before, {names}"
    when = datetime.fromtimestamp(written_s, UTC).replace(microsecond=0)
    return join(
        element("span", names or "no source yet", class_="source"),
        element(
            "span",
            f"{count(read.last, 'line')}, written ",
            element("time", f"{when:%Y-%m-%d %H:%M:%S} UTC", datetime=when.isoformat()),
        ),
    )


def document(page: Document) -> str:
    """The whole HTML text."""
    return "<!doctype html>" + element(
        "html",
        element(
            "head",
            element("meta", charset="utf-8"),
            element("meta", name="viewport", content="width=device-width, initial-scale=1"),
            element("meta", name="color-scheme", content="light dark"),
            element("title", f"{page.title} · wakeful"),
            element("link", rel="icon", href="/static/icon.svg", type="image/svg+xml"),
            element("link", rel="stylesheet", href=f"/static/page.css?{__version__}"),
            element("script", src=f"/static/page.js?{__version__}", defer=True) if page.live else None,
        ),
        element(
            "body",
            element("a", "To the content", href="#main", class_="skip"),
            element(
                "header",
                element("a", element("span", class_="eye", aria_hidden="true"), "wakeful", href="/", class_="brand"),
                element("p", page.parts.get("source"), id="source"),
                element("p", element("span", "as of loading; reload for news", id="live", role="status"), class_="live")
                if page.live
                else None,
            ),
            element("main", page.body, id="main", tabindex="-1"),
            element(
                "footer", element("p", f"wakeful {__version__}. This page only reads the journal; nothing here commands a robot.")
            ),
            data_live=page.live or None,
            data_position=page.position if page.live else None,
        ),
        lang="en",
    )

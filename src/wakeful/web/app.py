"""The page as an ASGI application: routes, each a view of the journal made in a thread of its own."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path

import anyio
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response, StreamingResponse
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from wakeful.contracts.journal import JournalError
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.views import History, NoSuchEvent
from wakeful.web import pages
from wakeful.web.asked import Asked
from wakeful.web.decided import Weigh
from wakeful.web.follow import Followed
from wakeful.web.guard import Guard
from wakeful.web.live import Streams, position_of
from wakeful.web.shell import Document, document

STATIC = Path(__file__).parent / "static"

Weighing = Callable[[SqliteJournal, History, Event, Decision], Sequence[tuple[str, float]]]
"""Recomputes what weighed most in a decision, as words with signed weights, the strongest first."""


def page(
    followed: Followed,
    *,
    names: Sequence[str] = (),
    remote: bool = False,
    weighing: Weighing = lambda *_: (),
    pause: Callable[[float], Awaitable[object]] = anyio.sleep,
    ending: Callable[[], bool] = lambda: False,
    most_streams: int = 32,
) -> Guard:
    """The application that shows a journal and writes nothing.

    Args:
        followed: the journal.
        names: host names under which it may be asked for, beside ``localhost`` and loopback addresses.
        remote: whether it may be asked for under other addresses too.
        weighing: what recomputes the weights of a decision; without it the page leaves them out.
        pause: how a stream waits between two looks.
        ending: whether the server is about to end.
        most_streams: how many streams of changes may be open at once.
    """
    streams = Streams(pause, ending, most_streams)

    def overview(asked: Asked) -> Document:
        return followed.look(lambda _journal, read: pages.overview(read, followed.written_s(), asked))

    def story(identity: str) -> tuple[Document, bool]:
        def view(journal: SqliteJournal, read: History) -> tuple[Document, bool]:
            weigh: Weigh = lambda event, decision: weighing(journal, read, event, decision)  # noqa: E731
            try:
                return pages.event(read, followed.written_s(), identity, weigh), True
            except NoSuchEvent as error:
                return pages.nothing(read, followed.written_s(), error), False

        return followed.look(view)

    def last() -> int:
        return followed.look(lambda _journal, read: read.last)

    async def show_overview(request: Request) -> Response:
        asked = Asked.of(request.query_params)
        return HTMLResponse(document(await anyio.to_thread.run_sync(overview, asked)))

    async def show_event(request: Request) -> Response:
        found, there = await anyio.to_thread.run_sync(story, request.path_params["identity"])
        return HTMLResponse(document(found), 200 if there else 404)

    async def stream_overview(request: Request) -> Response:
        asked = Asked.of(request.query_params)
        return streaming(request, lambda: overview(asked))

    async def stream_event(request: Request) -> Response:
        identity = request.path_params["identity"]
        return streaming(request, lambda: story(identity)[0])

    def streaming(request: Request, look: Callable[[], Document]) -> Response:
        if streams.full:
            return PlainTextResponse("too many pages are open", 503, {"Retry-After": "10"})
        position = position_of(request.headers.get("last-event-id", ""), request.query_params.get("after", ""))
        return StreamingResponse(streams.follow(last, look, position), media_type="text/event-stream")

    async def no_journal(_request: Request, error: Exception) -> Response:
        return HTMLResponse(document(pages.trouble(str(error))), 503)

    async def no_page(_request: Request, _error: Exception) -> Response:
        return HTMLResponse(document(pages.no_page()), 404)

    app = Starlette(
        routes=[
            Route("/", show_overview),
            Route("/live", stream_overview),
            Route("/event/{identity}", show_event),
            Route("/event/{identity}/live", stream_event),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        exception_handlers={JournalError: no_journal, 404: no_page},
    )
    return Guard(app, names, remote)

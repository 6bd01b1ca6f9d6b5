"""What every request must keep to: the host that it names, the method, and the headers of each answer."""

from __future__ import annotations

import ipaddress
from collections.abc import Sequence

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; "
        "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=()",
}


class Guard:
    """Lets through what names this machine and only reads.

    A page elsewhere may have its name resolve to this machine (DNS rebinding); its requests then carry that name as their
    host and are refused. An address can't be rebound.

    Args:
        app: what is guarded.
        names: host names that are this machine's, beside ``localhost``.
        remote: whether addresses other than loopback may be named too.
    """

    def __init__(self, app: ASGIApp, names: Sequence[str] = (), remote: bool = False) -> None:
        self._app = app
        self._names = {"localhost", *(name.lower() for name in names)}
        self._remote = remote

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse, or pass on and set the headers of the answer."""
        if scope["type"] != "http":
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
                headers.setdefault("Cache-Control", "no-store")
            await send(message)

        hosts = Headers(scope=scope).getlist("host")
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            refusal = "This page answers only under the address that `wakeful web` printed."
            await PlainTextResponse(refusal, 421)(scope, receive, with_headers)
        elif scope["method"] not in ("GET", "HEAD"):
            await PlainTextResponse("This page only shows.", 405, {"Allow": "GET, HEAD"})(scope, receive, with_headers)
        else:
            await self._app(scope, receive, with_headers)

    def _is_ours(self, host: str) -> bool:
        name = name_of(host)
        try:
            address = ipaddress.ip_address(name)
        except ValueError:
            return name in self._names
        return self._remote or address.is_loopback


def name_of(host: str) -> str:
    """The name or address of a Host header, without its port.

    >>> name_of("LocalHost:8765"), name_of("[::1]:8765"), name_of("127.0.0.1")
    ('localhost', '::1', '127.0.0.1')
    """
    if host.startswith("["):
        return host[1:].partition("]")[0].lower()
    return host.rpartition(":")[0].lower() if host.count(":") == 1 else host.lower()

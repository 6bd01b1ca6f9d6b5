"""Serving the page: where it may be reached, and how it ends."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable

import uvicorn

from wakeful.web.app import Weighing, page
from wakeful.web.follow import Followed

_GRACE_S = 4
"""Streams end by themselves within this; what is still open then is cut off."""


class Unreachable(Exception):
    """The page cannot be offered there. The message says why and what to do."""


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches ``host``: an address of the loopback range, or a name that resolves to nothing else.

    Raises:
        Unreachable: the name has no address.
    """
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        pass
    try:
        # An empty name would mean every address of this machine.
        found = {entry[4][0] for entry in socket.getaddrinfo(host, None)} if host else {"0.0.0.0"}
    except OSError as error:
        raise Unreachable(
            f"--host {host!r} has no address ({error.strerror or error}); give 127.0.0.1 or another address"
        ) from None
    return all(ipaddress.ip_address(str(address).partition("%")[0]).is_loopback for address in found)


def bound(host: str, port: int) -> socket.socket:
    """A listening socket; port 0 takes a free one.

    Raises:
        Unreachable: the port is taken, not allowed, or the address is not this machine's.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        family = socket.AF_INET
    else:
        family = socket.AF_INET if address.version == 4 else socket.AF_INET6
    try:
        return socket.create_server((host, port), family=family, backlog=128)
    except OSError as error:
        why = f"{host}:{port} cannot be listened on: {error.strerror or error}"
        raise Unreachable(f"{why}; give another --port (0 takes a free one) or another --host") from None


def url_of(listening: socket.socket, host: str) -> str:
    """Where a browser on this machine finds the page."""
    address, port = listening.getsockname()[:2]
    anywhere = ipaddress.ip_address(address).is_unspecified
    name = "127.0.0.1" if anywhere and ":" not in address else "::1" if anywhere else host
    return f"http://[{name}]:{port}/" if ":" in name else f"http://{name}:{port}/"


def serve(
    followed: Followed,
    host: str,
    listening: socket.socket,
    weighing: Weighing,
    ready: Callable[[str], None],
    remote: bool = False,
) -> None:
    """Serve until ctrl-C (KeyboardInterrupt) or SIGTERM; both end it with open pages too.

    Args:
        followed: the journal to show.
        host: the name or address that ``listening`` is bound to.
        listening: what ``bound`` gave; closed at the end.
        weighing: recomputes what weighed most in a decision.
        ready: called with the address once it can be asked for.
        remote: whether other machines may ask.
    """
    names = [host, *([socket.gethostname(), f"{socket.gethostname()}.local"] if remote else [])]
    running: list[uvicorn.Server] = []
    app = page(
        followed,
        names=names,
        remote=remote,
        weighing=weighing,
        ending=lambda: any(server.should_exit for server in running),
    )
    config = uvicorn.Config(
        app,
        log_level="warning",
        access_log=False,
        lifespan="off",
        ws="none",
        server_header=False,
        proxy_headers=False,
        timeout_graceful_shutdown=_GRACE_S,
    )
    server = uvicorn.Server(config)
    running.append(server)
    ready(url_of(listening, host))
    with listening:
        server.run(sockets=[listening])

"""The page over a real connection on this machine: who may ask, and how it ends."""

from __future__ import annotations

import http.client
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from wakeful.web.serve import Unreachable, bound, is_loopback, url_of


@pytest.mark.parametrize(("host", "alone"), [("127.0.0.1", True), ("::1", True), ("localhost", True), ("127.9.9.9", True)])
def test_loopback_is_this_machine_alone(host: str, alone: bool) -> None:
    assert is_loopback(host) is alone


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.0.1", ""])
def test_every_other_address_is_reached_by_others(host: str) -> None:
    assert not is_loopback(host)


def test_port_zero_takes_a_free_one_and_a_taken_one_is_refused() -> None:
    with bound("127.0.0.1", 0) as first:
        port = first.getsockname()[1]
        assert url_of(first, "127.0.0.1") == f"http://127.0.0.1:{port}/"
        with pytest.raises(Unreachable, match="another --port"):
            bound("127.0.0.1", port)


def test_an_address_of_another_machine_cannot_be_listened_on() -> None:
    with pytest.raises(Unreachable, match="another --host"):
        bound("192.0.2.1", 0)


def test_ctrl_c_ends_it_with_a_stream_open(journal: Path) -> None:
    command = [sys.executable, "-m", "wakeful", "web", "--journal", str(journal), "--port", "0"]
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment) as server:
        try:
            assert server.stdout is not None
            printed = server.stdout.readline()
            port = int(printed.split("http://127.0.0.1:")[1].split("/")[0])
            stream = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
            stream.request("GET", "/live?after=0")
            answer = stream.getresponse()
            assert answer.status == 200
            assert answer.readline() == b"retry: 2000\n"
            page = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
            page.request("GET", "/", headers={"Host": "evil.example"})
            assert page.getresponse().status == 421
            server.send_signal(signal.SIGINT)
            _, errors = server.communicate(timeout=30)
        finally:
            server.kill()
    assert errors == ""
    assert server.returncode == 130
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port), timeout=5)

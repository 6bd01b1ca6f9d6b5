"""The guards of conftest.py hold."""

from __future__ import annotations

import os
import socket

import pytest


def test_a_test_cannot_connect_beyond_this_machine() -> None:
    with socket.socket() as outside, pytest.raises(RuntimeError, match="may not connect"):
        outside.connect(("192.0.2.1", 9))


def test_a_test_cannot_look_up_a_name() -> None:
    with pytest.raises(RuntimeError, match="may not look up"):
        socket.create_connection(("example.com", 80))


def test_a_test_may_talk_to_itself() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server, socket.create_connection(server.getsockname()) as client:
        assert client.getpeername() == server.getsockname()


def test_no_key_or_setting_comes_from_outside() -> None:
    assert not [name for name in os.environ if name.startswith(("OPENAI_", "WAKEFUL_"))]

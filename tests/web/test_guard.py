"""The page answers only under its own address, only shows, and sends strict headers with everything."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.web.conftest import Browse

OURS = ["127.0.0.1:8765", "localhost", "LOCALHOST:1", "[::1]:8765", "127.8.9.1"]
FOREIGN = [
    "evil.example",
    "127.0.0.1.evil.example",
    "localhost.evil.example:8765",
    "192.168.1.5",
    "[2001:db8::1]",
    "",
    "[",
    "a:b:c",
    "127.1",
]


@pytest.mark.parametrize("host", OURS)
def test_a_host_that_is_this_machine_is_answered(browse: Browse, journal: Path, host: str) -> None:
    assert browse(journal).get("/", headers={"host": host}).status_code == 200


@pytest.mark.parametrize("host", FOREIGN)
@pytest.mark.parametrize("path", ["/", "/live", "/event/x", "/static/page.js"])
def test_a_foreign_host_is_refused_everywhere(browse: Browse, journal: Path, host: str, path: str) -> None:
    answer = browse(journal).get(path, headers={"host": host})
    assert answer.status_code == 421
    assert "wakeful web" in answer.text


def test_where_remote_is_allowed_addresses_and_given_names_are_answered_and_other_names_are_not(
    browse: Browse, journal: Path
) -> None:
    client = browse(journal, names=["robot-7"], remote=True)
    status = {host: client.get("/", headers={"host": host}).status_code for host in ("192.168.1.5:80", "Robot-7", "evil.example")}
    assert status == {"192.168.1.5:80": 200, "Robot-7": 200, "evil.example": 421}


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS"])
def test_nothing_but_reading_is_done(browse: Browse, journal: Path, method: str) -> None:
    assert browse(journal).request(method, "/").status_code == 405


@pytest.mark.parametrize("path", ["/", "/event/none", "/nowhere", "/static/page.css", "/static/../app.py"])
def test_every_answer_carries_the_headers_and_sets_no_cookie(browse: Browse, journal: Path, path: str) -> None:
    headers = browse(journal).get(path).headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert headers["x-content-type-options"] == "nosniff"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["cache-control"]
    assert "set-cookie" not in headers
    assert "access-control-allow-origin" not in headers

"""`wakeful simulate` writes a seeded stream."""

from __future__ import annotations

import json

from tests.cli.conftest import Wakeful


def test_the_same_seed_gives_the_same_messages(wakeful: Wakeful) -> None:
    first, again, other = (wakeful("simulate", "vda5050", "--messages", 20, "--seed", seed).stdout for seed in (1, 1, 2))
    assert first == again != other
    assert [set(json.loads(line)) >= {"headerId", "serialNumber", "errors"} for line in first.splitlines()] == [True] * 20


def test_a_domain_without_a_simulator_says_which_have_one(wakeful: Wakeful) -> None:
    result = wakeful("simulate", "px4_ulog")
    assert result.exit_code == 1
    assert "service_robot" in result.stderr

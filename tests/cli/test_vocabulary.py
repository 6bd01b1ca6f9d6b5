"""`domains` and `treatments` list what there is."""

from __future__ import annotations

import json

from tests.cli.conftest import Wakeful


def test_domains_lists_each_with_its_simulator_and_outcomes(wakeful: Wakeful) -> None:
    rows = {row["name"]: row for row in json.loads(wakeful("domains", "--json").stdout)}
    assert rows["service_robot"]["simulator"] is True
    assert all(row["says"] for row in rows.values())
    assert "service_robot" in wakeful("domains").stdout


def test_treatments_lists_the_eight(wakeful: Wakeful) -> None:
    names = [row["name"] for row in json.loads(wakeful("treatments", "--json").stdout)]
    assert {
        "description",
        "memory",
        "risk_prediction",
        "planning",
        "diagnosis",
        "analogy",
        "comparison",
        "causal_analysis",
    } <= set(names)

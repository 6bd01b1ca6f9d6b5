"""Prints what every treatment concludes on two events, as JSON: run under several hash seeds, the output must be the same."""

from __future__ import annotations

import msgspec

from tests.treatments.worlds import DOMAIN, episode, event, script
from wakeful.testing import ScriptedMind
from wakeful.treatments.registry import BUILT_IN

REMEMBERED = (
    episode("a", 100.0, outcome="stop", verdict="supported", load=0.4, state="normal"),
    episode("b", 200.0, kind="temperature_trend", outcome="none", load=0.2),
    episode("c", 300.0, entity="J4", outcome="none", verdict="contradicted", load=0.5, state="unstable"),
    episode("d", 400.0, kind="door_open", entity="door"),
)

if __name__ == "__main__":
    for treatment in BUILT_IN:
        for met in (
            event(load=0.9, state="unstable", temperature_c=75.0),
            event("route_blocked", "hall", start="dock", goal="loft"),
        ):
            for mode in ("auto", "delib", "fallback"):
                mind = ScriptedMind(DOMAIN, mode, script(*REMEMBERED, prior={"none": 0.8, "stop": 0.2}))  # type: ignore[arg-type]
                print(msgspec.json.encode(mind.run(treatment, met)).decode())

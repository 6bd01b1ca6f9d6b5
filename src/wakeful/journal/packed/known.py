"""What the hand-written writers and readers know of the facts that every automatic event writes: their fields, in order."""

from __future__ import annotations

from collections.abc import Mapping

from wakeful.facts.choices import Choice
from wakeful.facts.events import Condition, Context, Event
from wakeful.facts.evidence import Outcome
from wakeful.facts.experience import Experience
from wakeful.facts.lines import Judged
from wakeful.facts.packs import Covered, Ran, Validated
from wakeful.facts.time import Stamp

KNOWN: dict[type, str] = {
    Stamp: "source_ns clock uncertainty_ns received_ns",
    Context: "task zone safety fields",
    Condition: "key phase",
    Event: "id kind entity source position stamp ordinal robot relation fields context condition criticality deadline_s says "
    "observations truth_treatment",
    Choice: "basis shares prior novelty trust rests_on cell",
    Covered: "event process choice deadline_ns",
    Ran: "process event before steps_before steps treatment mode result closes_ns",
    Outcome: "id topic entity label at_ns event treatment acted_on origin source",
    Judged: "process event predicted label verdict outcome why lead_ns",
    Experience: "id event process treatment treatment_label predicted outcome verdict mode robot weight acted_on",
    Validated: "outcome judged experience trusted",
}


def as_known(schema: Mapping[str, tuple[str, ...]]) -> bool:
    """Whether a journal's rows have these facts with just these fields: else the general coders take them."""
    return all(schema[cls.__name__] == tuple(known.split()) for cls, known in KNOWN.items())

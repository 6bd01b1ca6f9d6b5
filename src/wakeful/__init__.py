"""Continuous cognitive coverage for robots: every admitted event gets a treatment that fits it.

>>> import wakeful
>>> with wakeful.Mind("service_robot") as mind:
...     receipt = mind.admit("object", "box 7", {"category": "obstacle", "state": "unstable", "location": "edge"})
...     mind.conclusion(receipt.event).treatment
'risk_prediction'
"""

from wakeful.contracts.treatment import Mind as MindView
from wakeful.contracts.treatment import Refusal
from wakeful.drivers.inline import Mind, open_live
from wakeful.drivers.live import LiveDriver, Receipt
from wakeful.facts.asking import Query, Question, Reply
from wakeful.facts.events import Context, Draft, Event, Observation
from wakeful.facts.evidence import Evidence, Outcome
from wakeful.facts.results import Forecast, Proposal, Result
from wakeful.facts.values import Field
from wakeful.treatments.decorator import treatment
from wakeful.treatments.registry import Registry
from wakeful.version import __version__

__all__ = [
    "Context",
    "Draft",
    "Event",
    "Evidence",
    "Field",
    "Forecast",
    "LiveDriver",
    "Mind",
    "MindView",
    "Observation",
    "Outcome",
    "Proposal",
    "Query",
    "Question",
    "Receipt",
    "Refusal",
    "Registry",
    "Reply",
    "Result",
    "__version__",
    "open_live",
    "treatment",
]

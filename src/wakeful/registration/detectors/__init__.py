"""The detectors that registration brings, one file each. A domain may bring its own beside them, under other names."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from wakeful.contracts.detector import DetectorFactory
from wakeful.registration.detectors.band import BandDetector
from wakeful.registration.detectors.conditions import ConditionsDetector
from wakeful.registration.detectors.cycle import CycleDetector
from wakeful.registration.detectors.edge import EdgeDetector
from wakeful.registration.detectors.jump import JumpDetector
from wakeful.registration.detectors.recurrence import RecurrenceDetector
from wakeful.registration.detectors.silence import SilenceDetector
from wakeful.registration.detectors.stall import StallDetector
from wakeful.registration.detectors.text import TextDetector
from wakeful.registration.detectors.threshold import ThresholdDetector
from wakeful.registration.detectors.trend import TrendDetector

BUILT_IN: Mapping[str, DetectorFactory] = MappingProxyType(
    {
        "band": BandDetector,
        "conditions": ConditionsDetector,
        "cycle": CycleDetector,
        "edge": EdgeDetector,
        "jump": JumpDetector,
        "recurrence": RecurrenceDetector,
        "silence": SilenceDetector,
        "stall": StallDetector,
        "text": TextDetector,
        "threshold": ThresholdDetector,
        "trend": TrendDetector,
    }
)

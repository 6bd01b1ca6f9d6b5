"""The detectors of PX4 flights by name: what the domain's data cannot say."""

from __future__ import annotations

from wakeful.contracts.detector import DetectorFactory
from wakeful.domains.px4_ulog.airframe import Airframe
from wakeful.domains.px4_ulog.battery import Batteries
from wakeful.domains.px4_ulog.checks import Checks
from wakeful.domains.px4_ulog.estimator import Estimators
from wakeful.domains.px4_ulog.flags import Flags
from wakeful.domains.px4_ulog.messages import Messages
from wakeful.domains.px4_ulog.modes import Modes
from wakeful.domains.px4_ulog.recording import Recording
from wakeful.domains.px4_ulog.resets import Resets
from wakeful.domains.px4_ulog.satellites import Satellites

DETECTORS: dict[str, DetectorFactory] = {
    "px4_modes": Modes,
    "px4_messages": Messages,
    "px4_flags": Flags,
    "px4_checks": Checks,
    "px4_battery": Batteries,
    "px4_estimator": Estimators,
    "px4_resets": Resets,
    "px4_gps": Satellites,
    "px4_airframe": Airframe,
    "px4_recording": Recording,
}

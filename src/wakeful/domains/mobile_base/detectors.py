"""The detectors of mobile bases by name: what the domain's data cannot say."""

from __future__ import annotations

from wakeful.contracts.detector import DetectorFactory
from wakeful.domains.mobile_base.contacts import Contacts
from wakeful.domains.mobile_base.drive import Drive
from wakeful.domains.mobile_base.following import Following
from wakeful.domains.mobile_base.jumps import Jumps
from wakeful.domains.mobile_base.obstacles import Obstacles
from wakeful.domains.mobile_base.reports import Reports
from wakeful.domains.mobile_base.shocks import Shocks
from wakeful.domains.mobile_base.silence import Silence
from wakeful.domains.mobile_base.slip import Slip

DETECTORS: dict[str, DetectorFactory] = {
    "base_drive": Drive,
    "base_following": Following,
    "base_slip": Slip,
    "base_obstacles": Obstacles,
    "base_silence": Silence,
    "base_jumps": Jumps,
    "base_shocks": Shocks,
    "base_reports": Reports,
    "base_contacts": Contacts,
}

"""Explicit deliberation: reasoners behind one contract, and the limits around them."""

from wakeful.deliberation.reasoners import REASONERS, make
from wakeful.deliberation.settings import ReasonerSettings, SettingsError, from_environment

__all__ = ["REASONERS", "ReasonerSettings", "SettingsError", "from_environment", "make"]

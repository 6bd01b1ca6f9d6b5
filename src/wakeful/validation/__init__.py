"""Validation: recorded result + outcome → verdict → experience."""

from wakeful.validation.validation import Counts, Validation
from wakeful.validation.verdict import verdict

__all__ = ["Counts", "Validation", "verdict"]

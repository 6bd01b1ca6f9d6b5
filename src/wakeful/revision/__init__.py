"""Revision: trust per treatment; contradiction → lower trust, reopen, learn again, re-automate."""

from wakeful.revision.debts import Debts
from wakeful.revision.revision import Revision, RevisionSettings
from wakeful.revision.standing import Made, Stale

__all__ = ["Debts", "Made", "Revision", "RevisionSettings", "Stale"]

"""Admission: event → admitted, or duplicate, or refused with a reason."""

from wakeful.admission.admission import Admission, Counts

__all__ = ["Admission", "Counts"]

"""What a contract suite raises, and the one way in which it does."""

from __future__ import annotations


class ContractBroken(AssertionError):
    """Something does not keep its contract. The message says what, where, and what was expected."""


def require(kept: bool, otherwise: str) -> None:
    """Raise ContractBroken with ``otherwise`` unless ``kept``."""
    if not kept:
        raise ContractBroken(otherwise)

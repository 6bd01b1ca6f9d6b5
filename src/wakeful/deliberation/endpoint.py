"""What the openai reasoner needs of an endpoint: one chat completion, or an error that says whose fault it was."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol

import msgspec

from wakeful.contracts.reasoner import ReasonerError
from wakeful.deliberation.permit import Fault
from wakeful.facts.values import Value


class Turn(msgspec.Struct, frozen=True):
    """One message of a chat."""

    role: str
    content: str


class Completion(msgspec.Struct, frozen=True):
    """What an endpoint answered: text, why it ended, and the tokens it bills; None where it does not say."""

    text: str
    finish: str = ""
    prompt_tokens: int | None = None
    completion_tokens: int | None = None


class Unavailable(ReasonerError, Fault):
    """The endpoint failed: no connection, overloaded, 5xx, not an OpenAI answer. ``again``: worth another try."""

    def __init__(self, message: str, *, again: bool = True, retry_after_s: float = 0.0) -> None:
        super().__init__(message)
        self.again = again
        self.retry_after_s = retry_after_s


class Rejected(ReasonerError):
    """The endpoint works and refused this very request (400, 413, 422): another question may be answered."""


class Endpoint(Protocol):
    """Something that completes a chat."""

    async def complete(self, turns: Sequence[Turn], response_format: Mapping[str, Value]) -> Completion:
        """One call, without retries. Raises Unavailable or Rejected."""

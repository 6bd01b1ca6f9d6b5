"""The declared overload policy: what is given up, in which order, when more comes than can be thought about."""

from __future__ import annotations

import msgspec

from wakeful.facts.values import Fact

#: What the reason begins with where deliberation was shed, and where an event was refused at admission.
SHED = "overload: not deliberated"
REFUSED = "overload: refused"

#: No limit at all: for experiments whose workload is the question.
NO_LIMIT = 2**62


class OverloadSettings(Fact, frozen=True):
    """When more comes than can be thought about. The backlog is what has not begun to be treated, or queues for the reasoner.

    First deliberation is shed: from ``shed_backlog`` on, or where the oldest has waited for ``shed_age_s``, an event that is not
    critical gets its treatment in fallback mode, and is debt. Only then coverage is: from ``refuse_backlog`` on an event is
    refused at admission, with its reason, counted; what is not critical sooner, so that the share ``reserve`` of the room
    stays for criticals; what comes from a source that holds the share ``source_share`` of the room left, sooner still. With
    ``most_open`` processes open, waiting ones too, the same: it bounds memory. A live mind makes callers wait before it refuses.
    """

    shed_backlog: int = 500
    shed_age_s: float = 120.0
    refuse_backlog: int = 5_000
    reserve: float = 0.2
    source_share: float = 0.75
    most_open: int = 2_000_000


UNLIMITED = OverloadSettings(shed_backlog=NO_LIMIT, shed_age_s=1e9, refuse_backlog=NO_LIMIT, most_open=NO_LIMIT)


class Load(msgspec.Struct, frozen=True):
    """How much is to be thought about: the backlog, how much of it is of one source, for how long the oldest has waited."""

    backlog: int
    of_source: int
    oldest_s: float
    open: int

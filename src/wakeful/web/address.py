"""How an event is named on every page, and where its own page is."""

from __future__ import annotations

from urllib.parse import quote

from wakeful.web.markup import clean

_KIND, _ENTITY = 60, 80
"""At most so many letters of each."""


def address(event: str) -> str:
    """The page of an event.

    >>> address("a/../b?c")
    '/event/a%2F..%2Fb%3Fc'
    """
    return f"/event/{quote(event, safe='')}"


def name_of(kind: str, entity: str) -> str:
    """An event in three words.

    >>> name_of("grip_lost", "gripper")
    'grip_lost of gripper'
    """
    return f"{clean(kind, _KIND)} of {clean(entity, _ENTITY)}" if entity else clean(kind, _KIND)

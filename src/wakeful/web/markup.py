"""HTML that cannot be broken out of: every text is escaped unless it was made here."""

from __future__ import annotations

import unicodedata
from html import escape
from typing import TypeAlias

#: Elements that have no end tag.
_VOID = {"input", "link", "meta", "hr", "br"}
#: Control, invisible, direction-changing and private letters: no text of the world may hide or turn round what stands beside it.
_UNSHOWN = {"Cc", "Cf", "Cs", "Co", "Cn"}


class Markup(str):
    """Text that is HTML already. Only ``element`` and ``join`` make it."""

    __slots__ = ()


Child: TypeAlias = "Markup | str | int | None"


def clean(text: str, limit: int = 0) -> str:
    """Outside text without what cannot be seen, cut to ``limit`` letters.

    >>> clean("grip\\u202e lost\\nnow"), clean("abcdef", 4)
    ('grip lost now', 'abc…')
    """
    if limit and len(text) > limit:
        text = text[: limit - 1] + "…"
    if text.isprintable():
        return text
    return "".join(
        " " if letter in "\n\r\t" else letter
        for letter in text
        if letter in "\n\r\t" or unicodedata.category(letter) not in _UNSHOWN
    )


def text(child: Child) -> Markup:
    """Anything as HTML: markup as it is, everything else escaped.

    >>> text("<b>")
    '&lt;b&gt;'
    """
    if isinstance(child, Markup):
        return child
    return Markup(escape(clean("" if child is None else str(child)), quote=True))


def join(*children: Child) -> Markup:
    """Several pieces, one after the other."""
    return Markup("".join(text(child) for child in children))


def element(name: str, /, *children: Child, **attributes: str | float | bool | None) -> Markup:
    """One element. Attributes that are None or False are left out, True stands without a value; ``class_`` is ``class``,
    and underscores become hyphens.

    >>> element("a", "x < y", href="/?a=1&b=2", class_="far")
    '<a href="/?a=1&amp;b=2" class="far">x &lt; y</a>'
    """
    written = "".join(
        f" {key.rstrip('_').replace('_', '-')}" + ("" if value is True else f'="{text(str(value))}"')
        for key, value in attributes.items()
        if value is not None and value is not False
    )
    if name in _VOID:
        return Markup(f"<{name}{written}>")
    return Markup(f"<{name}{written}>{join(*children)}</{name}>")

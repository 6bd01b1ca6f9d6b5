"""Which events the page was asked for, and the form that asks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from urllib.parse import urlencode

import msgspec

from wakeful.facts.experience import Verdict
from wakeful.journal.debt import in_debt
from wakeful.journal.results import result_says
from wakeful.journal.rows import EventRow, event_row
from wakeful.journal.views import EventPast, History
from wakeful.web.figures import MODE_WORDS
from wakeful.web.markup import Markup, element, join

_LONGEST = 200
_KINDS = 60
"""So many kinds can be chosen, the most common ones; any can be named in the address."""


class Asked(msgspec.Struct, frozen=True, kw_only=True):
    """A filter over events; an empty field lets all through. ``before`` is a journal position: only earlier events."""

    kind: str = ""
    mode: str = ""
    verdict: str = ""
    text: str = ""
    only: str = ""
    before: int = 0

    @classmethod
    def of(cls, query: Mapping[str, str]) -> Asked:
        """The filter that an address's query states. What is no filter is passed over."""
        before = query.get("before", "")
        return cls(
            kind=query.get("kind", "")[:_LONGEST],
            mode=query["mode"] if query.get("mode") in MODE_WORDS else "",
            verdict=query["verdict"] if query.get("verdict") in tuple(Verdict) else "",
            text=query.get("text", "").strip()[:_LONGEST],
            only=query["only"] if query.get("only") in ("open", "debt") else "",
            before=int(before) if before.isascii() and before.isdigit() and len(before) < 16 else 0,
        )

    @property
    def any(self) -> bool:
        """Whether it leaves anything out, its page aside."""
        return bool(self.kind or self.mode or self.verdict or self.text or self.only)

    def query(self, **changes: str | int) -> str:
        """The query of an address that states it, or it with changes; empty where it lets all through."""
        stated = msgspec.structs.asdict(msgspec.structs.replace(self, **changes))
        found = urlencode({name: value for name, value in stated.items() if value})
        return f"?{found}" if found else ""

    def matching(self, read: History) -> Iterator[tuple[EventPast, EventRow]]:
        """The events that it lets through, the latest first."""
        wanted = self.text.casefold()
        for past in reversed(read.events.values()):
            if self.before and past.position >= self.before:
                continue
            if self.kind and past.event.kind != self.kind:
                continue
            row = event_row(read, past)
            if (self.mode and row.mode != self.mode) or (self.verdict and row.verdict != self.verdict):
                continue
            if self.only == "debt" and not in_debt(read, past):
                continue
            if self.only == "open" and not any(read.processes[each].open for each in past.processes):
                continue
            if wanted and not any(wanted in part.casefold() for part in self._parts(read, row)):
                continue
            yield past, row

    def _parts(self, read: History, row: EventRow) -> Iterator[str]:
        yield from (row.kind, row.entity, row.says, row.treatment, row.id)
        root = read.root(row.id)
        if root and root.concluded:
            yield result_says(root.concluded.result)


def form(asked: Asked, read: History) -> Markup:
    """The form that asks: it works without scripts, and leaves nothing in the address that was left empty."""
    found = Counter(past.event.kind for past in read.events.values() if len(past.event.kind) <= _LONGEST)
    kinds = sorted({kind for kind, _ in found.most_common(_KINDS)} | ({asked.kind} if asked.kind else set()))
    return element(
        "form",
        _select("kind", "Kind", "every kind", [(kind, kind) for kind in kinds], asked.kind),
        _select("mode", "Mode", "every mode", list(MODE_WORDS.items()), asked.mode),
        _select("verdict", "Verdict", "every verdict", [(each.value, each.value) for each in Verdict], asked.verdict),
        _select("only", "State", "open and done", [("open", "still open"), ("debt", "in debt")], asked.only),
        element(
            "label",
            element("span", "Text"),
            element(
                "input",
                type="search",
                name="text",
                value=asked.text,
                maxlength=_LONGEST,
                placeholder="met or concluded",
            ),
        ),
        element("button", "Filter", type="submit"),
        element("a", "Show all", href="/", class_="plain") if asked.any or asked.before else None,
        method="get",
        action="/",
        role="search",
        aria_label="Events",
        class_="filter",
    )


def _select(name: str, label: str, every: str, options: list[tuple[str, str]], chosen: str) -> Markup:
    return element(
        "label",
        element("span", label),
        element(
            "select",
            element("option", every, value=""),
            join(*(element("option", says, value=value, selected=value == chosen) for value, says in options)),
            name=name,
        ),
    )

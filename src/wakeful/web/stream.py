"""The stream: the latest events, how each was treated, what it concluded and how that ended."""

from __future__ import annotations

from itertools import islice

from wakeful.journal.results import result_says
from wakeful.journal.rows import EventRow
from wakeful.journal.views import EventPast, History, StrangeEpisode
from wakeful.journal.wording.episodes import ending_words
from wakeful.journal.wording.words import instant
from wakeful.web.address import address, name_of
from wakeful.web.asked import Asked
from wakeful.web.figures import MODE_WORDS
from wakeful.web.markup import Markup, clean, element, join
from wakeful.web.now import grade

SHOWN = 30
_LONGEST = 320
_VERDICT_MARKS = {"supported": "✓", "contradicted": "✗", "undecided": "?"}


def stream(read: History, asked: Asked) -> Markup:
    """The latest events that the filter lets through, the latest first, with the way to earlier ones."""
    found = list(islice(asked.matching(read), SHOWN + 1))
    if not found:
        return element(
            "p", "No event is like that." if asked.any or asked.before else "No event has been admitted yet.", class_="calm"
        )
    shown = found[:SHOWN]
    earlier = f"/{asked.query(before=shown[-1][0].position)}#events" if len(found) > SHOWN else ""
    latest = f"/{asked.query(before=0)}#events" if asked.before else ""
    return join(
        element("ol", *(_item(read, past, row) for past, row in shown), class_="stream"),
        element(
            "nav",
            element("a", "← Latest", href=latest, id="latest") if latest else None,
            element("a", "Earlier →", href=earlier, id="earlier") if earlier else None,
            aria_label="Pages of events",
            class_="pages",
        )
        if latest or earlier
        else None,
    )


def _item(read: History, past: EventPast, row: EventRow) -> Markup:
    root = read.root(row.id)
    says = result_says(root.concluded.result) if root and root.concluded else ""
    return element(
        "li",
        element(
            "p",
            element("span", instant(row.at_ns), class_="when"),
            grade(row.criticality) if row.criticality else None,
            element("a", name_of(row.kind, row.entity), href=address(row.id), id=f"event-{past.position}"),
            class_="head",
        ),
        element("p", clean(row.says, _LONGEST)) if row.says else None,
        element("p", clean(concluded(row.says, says), _LONGEST), class_="concluded") if says else None,
        element("p", chips(row.treatment, row.mode, row.state, row.verdict), class_="chips"),
        id=f"row-{past.position}",
    )


def concluded(met: str, says: str) -> str:
    """What was concluded, without the beginning that only repeats what was met (whole, or cut with an ellipsis).

    >>> concluded("box 7 fell", "box 7 fell: a high risk"), concluded("box 7 fell over there", "box 7 fell…: a detour")
    ('a high risk', 'a detour')
    """
    repeated = next((index for index, (a, b) in enumerate(zip(met, says, strict=False)) if a != b), min(len(met), len(says)))
    rest = says[repeated:]
    if repeated and (repeated == len(met) or rest.startswith("…")):
        return rest.lstrip("… :;,") or says
    return says


def chips(treatment: str, mode: str, state: str, verdict: str) -> Markup:
    """Treatment, mode, and the verdict, or the state where there is none."""
    return join(
        element("span", clean(treatment, 60) or "none", class_="chip"),
        element("span", MODE_WORDS[mode], class_=f"chip mode mode-{mode}") if mode in MODE_WORDS else None,
        element("span", f"{_VERDICT_MARKS[verdict]} {verdict}", class_=f"chip {verdict}")
        if verdict in _VERDICT_MARKS
        else element("span", state, class_="chip state"),
    )


def strange(episodes: tuple[StrangeEpisode, ...]) -> Markup:
    """The strangest episodes: what surprised its own forecast most."""
    if not episodes:
        return element("p", "Nothing has surprised a forecast yet.", class_="calm")
    return element(
        "ol",
        *(
            element(
                "li",
                element(
                    "p",
                    element("span", instant(episode.at_ns), class_="when"),
                    element("a", name_of(episode.kind, episode.entity), href=address(episode.event), id=f"strange-{index}"),
                    class_="head",
                ),
                element("p", clean(episode.says, _LONGEST)),
                element("p", clean(ending_words(episode), _LONGEST), class_="concluded"),
                element(
                    "p", chips(episode.treatment, episode.mode, episode.end or episode.state, episode.verdict), class_="chips"
                ),
            )
            for index, episode in enumerate(episodes)
        ),
        class_="stream",
    )

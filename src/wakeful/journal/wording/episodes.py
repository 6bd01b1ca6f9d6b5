"""How a strange episode ended, in words."""

from __future__ import annotations

from wakeful.journal.strange import StrangeEpisode
from wakeful.journal.wording.words import duration, percent, plain


def ending_words(episode: StrangeEpisode) -> str:
    """What the world showed, what the forecast had given to it, and the verdict."""
    if not episode.verdict:
        return f"{episode.end or episode.state}; the world has not shown yet whether it was right"
    after = f" {duration(episode.judged_after_s)} later" if episode.judged_after_s is not None else ""
    shown = "the world showed" if episode.judged_after_s is not None else "nothing came in its window, which counts as"
    shown = f"{shown} {plain(episode.label)}"
    given = f", to which it had given {percent(episode.label_probability)}" if episode.label_probability is not None else ""
    reopened = "; reopened" if episode.reopened else ""
    if episode.verdict == "undecided":
        return f"undecided: it forecast {plain(episode.predicted)}, and the world did not show it either way{reopened}"
    if episode.verdict == "contradicted":
        return f"{shown}{after}{given}; it had forecast {plain(episode.predicted)}: contradicted{reopened}"
    return f"{shown}{after}{given}: supported{reopened}"

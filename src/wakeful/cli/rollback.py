"""`wakeful rollback VERSION`: decide with an earlier model version again."""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

import click

from wakeful.cli.handing import THIS_COMMAND, hand, wait_option, who_option, why_option
from wakeful.cli.mistakes import Mistake
from wakeful.cli.options import journal_option, json_option, named_journal, print_json, reading
from wakeful.cli.terminal import say
from wakeful.facts.inputs import Act
from wakeful.journal.views import history
from wakeful.journal.wording.words import duration


@click.command("rollback")
@click.argument("version", type=click.IntRange(min=1))
@who_option
@why_option
@journal_option
@wait_option
@json_option
def rollback_command(version: int, who: str, why: str, journal: Path | None, wait_s: float, as_json: bool) -> None:
    """Decide with model VERSION from now on; what is learned next goes on from it. A training that is under way is dropped.

    Nothing is forgotten: experiences stay, later versions stay listed by 'wakeful learning', and each decision names the
    version that made it.
    """
    path = named_journal(journal)
    with reading(path) as opened:
        published = {each.card.version: each.card for _, each in history(opened).published}
    card = published.get(version)
    accepted = ", ".join(str(each.version) for each in published.values() if each.accepted) or "none"
    if card is None or not card.accepted:
        what = "there is no model version" if card is None else "never accepted was model version"
        raise Mistake(f"{what} {version} in {path}; accepted are: {accepted}")
    (done,) = hand(path, [Act(who=who, act="rollback", process=0, why=why, id=uuid4().hex, version=version)], wait_s)
    if as_json:
        print_json(done)
    elif not done.recorded:
        say(f"handed to process {done.by}, which has not recorded it within {duration(wait_s)}: it does with its next input")
    else:
        where = "the next run begins with it" if done.by == THIS_COMMAND else f"process {done.by} decides with it now"
        say(f"model version {version}, learned from {card.watermark} experiences: {where} (line {done.position})")

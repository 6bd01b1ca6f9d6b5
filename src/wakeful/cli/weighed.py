"""What weighed most in a model's decision, recomputed exactly with the model version that was recorded."""

from __future__ import annotations

import msgspec

from wakeful.contracts.domain import DomainError
from wakeful.contracts.grounds import Grounded, Grounds
from wakeful.contracts.journal import JournalError
from wakeful.domains import load, names
from wakeful.facts.decisions import Decision
from wakeful.facts.events import Event
from wakeful.journal.sqlite import SqliteJournal
from wakeful.journal.views import History
from wakeful.learning.pooled import Pooled
from wakeful.selection.explain import Contribution, contributions
from wakeful.selection.features import Encoder
from wakeful.selection.rule_words import RuleWords
from wakeful.treatments.registry import Registry


class CannotRecompute(Exception):
    """The domain or the model version is not here as it was. The message says which."""


class Weighed(msgspec.Struct, frozen=True):
    """``fields``: the effect of each of the event's fields, the greatest first. ``grounds``: the parts of the model and the rules
    that spoke, which ``words`` puts into the domain's names; None where the model has no learned rules."""

    fields: tuple[Contribution, ...] = ()
    grounds: Grounds | None = None
    words: RuleWords | None = None


def weighed(journal: SqliteJournal, read: History, event: Event, decision: Decision) -> Weighed:
    """What the model version that decided made of the event; nothing where guidelines decided.

    Raises:
        CannotRecompute: the domain is not on this machine in the recorded version, or the model needs other features.
    """
    card = next((record.card for _, record in read.published if record.card.version == decision.model), None)
    if card is None or not decision.model:
        return Weighed()
    opened = read.opened[-1]
    # A journal from elsewhere may name a path; only what is installed is run.
    if opened.domain not in names():
        raise CannotRecompute(f"the domain {opened.domain} is not on this machine")
    try:
        spec = load(opened.domain).spec
    except DomainError as error:
        raise CannotRecompute(f"the domain {opened.domain} is not on this machine") from error
    if spec.version != opened.domain_version:
        raise CannotRecompute(f"the domain {spec.name} has version {spec.version} now, it was {opened.domain_version}")
    encoder = Encoder(spec, spec.treatments or Registry().names())
    try:
        predictor = Pooled().load(journal.blob(card.blob))
    except (ValueError, JournalError) as error:
        raise CannotRecompute(f"the weights of model version {card.version} are not there as they were: {error}") from error
    if predictor.typical.shape != (encoder.size,):
        raise CannotRecompute(f"the domain {spec.name} has other features now than model version {card.version} learned from")
    grounds = predictor.grounds(encoder.encode(event), decision.treatment) if isinstance(predictor, Grounded) else None
    return Weighed(contributions(encoder, predictor, event, decision.treatment), grounds, RuleWords(encoder))

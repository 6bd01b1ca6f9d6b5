"""What memory changes about a decision: it lets an event be automatic again, or stops it from being so."""

from __future__ import annotations

from typing import Final

import msgspec

from wakeful.facts.decisions import Candidate, Decision
from wakeful.facts.recollection import Recollection

SURE: Final = 0.5
"""How far what memory says must be believed for automatic execution."""
RELIABLE: Final = 0.15
"""Where fewer of its validations than this are wrong, one that contradicts what is believed is not passed over."""
NOISY: Final = 0.25
"""Where more of its validations are wrong than this, or seem so, an event is left to the model."""


def with_memory(decision: Decision, recalled: Recollection | None) -> Decision:
    """The decision as memory of sufficiently similar events would have it; unchanged where it has nothing to say.

    Memory takes the place of the model's treatment and forecast. What it says is automatic if it is believed and confirmed: an
    event whose outcome was contradicted is deliberated until an experience that ended so was supported, or until its right
    treatment was told. Where the guarantee gate ruled, memory may stop automation and never allow it.

    Args:
        decision: the selector's, without memory.
        recalled: what memory says of the event.

    Returns:
        A decision that names the exemplar. Its trust is at least how far memory is believed: a contradiction of this very event
        has been taken up there, and one of the treatment elsewhere says less of it.
    """
    if recalled is None:
        return decision
    kept = msgspec.structs.replace(decision, recalled=recalled.exemplar)
    if recalled.noise > NOISY:
        return kept
    treatment = recalled.treatment or decision.treatment
    prior = recalled.labels or decision.prior
    doubts = _doubts(recalled)
    if decision.audit is not None and decision.mode != "auto":
        doubts.append("The guarantee gate did not allow it to be automatic.")
    label = recalled.label
    said = (
        f"Like experience {recalled.exemplar} (likeness {recalled.likeness:.2f}), last validated by experience "
        f"{recalled.experiences[0]}: {treatment}" + (f", {label!r} with {recalled.labels[label]:.3f}." if label else ".")
    )
    likeliest = max(decision.prior, key=lambda name: decision.prior[name], default="")
    same = treatment == decision.treatment and label == likeliest
    if same and not doubts and decision.mode == "auto":
        return kept
    confidence = round(recalled.treatment_share if recalled.treatment else decision.confidence, 6)
    return msgspec.structs.replace(
        kept,
        treatment=treatment,
        mode="delib" if doubts else "auto",
        confidence=confidence,
        candidates=_ranked(decision, treatment, confidence),
        reasons=(said, *(doubts or [f"Automatic: memory holds it with {recalled.share:.3f} (at least {SURE:g})."])),
        gate=msgspec.structs.replace(
            decision.gate,
            confidence=confidence,
            threshold=SURE,
            novelty=0.0,
            trust=round(max(decision.gate.trust, recalled.share), 6),
        ),
        prior=prior,
        foretold=decision.foretold or (decision.prior if decision.model and prior is not decision.prior else {}),
        rests_on=recalled.experiences,
    )


def _doubts(recalled: Recollection) -> list[str]:
    doubts: list[str] = []
    if not recalled.treatment:
        doubts.append("Its right treatment was never told.")
    elif not recalled.confirmed:
        doubts.append(f"No experience of it that ended in {recalled.label!r} has confirmed a treatment yet.")
    if recalled.contradicted and recalled.noise < RELIABLE:
        doubts.append(f"Its last validation told otherwise, and only {recalled.noise:.1%} of them are expected to be wrong.")
    if recalled.share < SURE:
        doubts.append(f"Memory holds it with {recalled.share:.3f} only, below {SURE:g}.")
    return doubts


def _ranked(decision: Decision, treatment: str, share: float) -> tuple[Candidate, ...]:
    """The treatment with its share, then the others, which share the rest as before."""
    others = [each for each in decision.candidates if each.treatment != treatment]
    known = sum(each.probability for each in others)
    rest = [round((1.0 - share) * each.probability / known, 9) if known > 0.0 else 0.0 for each in others]
    return (
        Candidate(treatment=treatment, probability=share),
        *(Candidate(treatment=each.treatment, probability=left) for each, left in zip(others, rest, strict=True)),
    )

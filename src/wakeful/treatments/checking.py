"""Which check would tell most about the faults, and what a reading that came says of their symptoms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from wakeful.facts.evidence import Evidence
from wakeful.facts.values import Fact
from wakeful.treatments.measures import significant
from wakeful.treatments.noisy_or import Network
from wakeful.treatments.symptoms import holds, split
from wakeful.treatments.waiting import Askable, about, reading
from wakeful.treatments.wording import worded


class Check(Fact, frozen=True):
    """A symptom to look for, and how much it is expected to tell."""

    symptom: str
    gain_bits: float
    chance: float
    evidence: str = ""
    """Where it can be asked for; empty: only a person can look."""


def most_telling(
    network: Network, known: Mapping[str, bool], offers: Sequence[Askable], asked: Sequence[str], least_gain_bits: float
) -> tuple[Check | None, Askable | None]:
    """The open symptom with the greatest expected gain, of those that evidence can be had for if there are any."""
    checks = []
    # words stand in what was said or they don't: there is nothing to look for
    open_ = [symptom for symptom in network.symptoms if (split(symptom) or ("", "", ""))[1] != "~"]
    unknown = [symptom for symptom in open_ if symptom not in known and symptom not in asked]
    for symptom, (chance, gain) in network.look_for(unknown, known).items():
        if gain >= least_gain_bits:
            offered = about(offers, _field(symptom)) if split(symptom) else ()
            address = offered[0].address if offered else ""
            found = Check(symptom=symptom, gain_bits=significant(gain, 4), chance=significant(chance, 4), evidence=address)
            checks.append((found, offered[0] if offered else None))
    return min(checks, key=lambda each: (each[1] is None, -each[0].gain_bits, each[0].symptom), default=(None, None))


def take_in(network: Network, offer: Askable, evidence: Evidence, known: dict[str, bool], heard: list[str]) -> None:
    """Every symptom that the evidence tells of, not only the one that it was asked for."""
    for symptom in network.symptoms:
        condition = split(symptom)
        if symptom in known or condition is None or not about((offer,), condition[0]):
            continue
        value = reading(evidence, condition[0])
        shown = holds(condition, {condition[0]: value})
        if shown is not None:
            known[symptom] = shown
            line = f"evidence {offer.address} at {evidence.at_ns}: {worded(condition[0], value)}"
            if line not in heard:  # one reading may speak to several bounds
                heard.append(line)


def _field(symptom: str) -> str:
    condition = split(symptom)
    return symptom if condition is None else condition[0]

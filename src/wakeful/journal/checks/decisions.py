"""Decisions: what was automatic passed its recorded gate, results carry what was decided, and trust moves from where it stood."""

from __future__ import annotations

from wakeful.facts.decisions import Decision, Gate
from wakeful.facts.lines import Compacted, Concluded, Decided, Gained, Imported, Line, Trusted
from wakeful.journal.checks.check import Check


class Gates(Check):
    """Automatic execution only through the gate; and a result says the treatment and the mode that were decided last."""

    name = "gates"
    says = "what was automatic passed its recorded gate, and every result carries the treatment and mode that were decided"

    def __init__(self) -> None:
        super().__init__()
        self._decided: dict[int, Decision] = {}

    def see(self, line: Line) -> None:
        """Follow a decision to its result."""
        record = line.record
        if isinstance(record, Decided):
            self.checked += 1
            self._decided[record.process] = record.decision
            shut = _shut(record.decision.gate) if record.decision.mode == "auto" else ""
            if shut:
                self.offend(line, f"process {record.process} was decided automatic, but {shut}")
        elif isinstance(record, Concluded):
            self.checked += 1
            decision = self._decided.get(record.process)
            if decision is None:
                self.offend(line, f"process {record.process} concluded, but nothing was decided")
            elif (decision.treatment, decision.mode) != (record.treatment, record.mode):
                self.offend(
                    line,
                    f"process {record.process} concluded by {record.treatment} in {record.mode}, "
                    f"but {decision.treatment} in {decision.mode} was decided",
                )


class Trust(Check):
    """Trust in a treatment changes from the level at which it was left, between 0 and 1, for an experience that there is."""

    name = "trust"
    says = "every change of trust begins where the last one of its treatment ended, and names an experience that was gained"

    def __init__(self) -> None:
        super().__init__()
        self._level: dict[str, float] = {}
        self._experiences = 0

    def see(self, line: Line) -> None:
        """Follow each treatment's trust."""
        record = line.record
        if isinstance(record, Gained | Imported):
            self._experiences += 1
        elif isinstance(record, Compacted):
            # Changes of trust may be among what was given up: the next one of each treatment says where it stood.
            self._experiences += record.gained
            self._level.clear()
        elif isinstance(record, Trusted):
            self.checked += 1
            level = self._level.get(record.treatment, record.before)
            if record.before != level:
                self.offend(line, f"trust in {record.treatment} moves from {record.before:g}, but it stood at {level:g}")
            elif not 0.0 <= record.after <= 1.0:
                self.offend(line, f"trust in {record.treatment} becomes {record.after:g}; it lies between 0 and 1")
            elif record.experience > self._experiences:
                self.offend(line, f"trust in {record.treatment} moves for experience {record.experience}, which is not there")
            self._level[record.treatment] = record.after


def _shut(gate: Gate) -> str:
    """What keeps the gate shut, by the numbers that were compared; empty where it is open."""
    if not gate.confidence >= gate.threshold:
        return f"the confidence {gate.confidence:g} is below {gate.threshold:g}"
    if not gate.novelty <= gate.novelty_limit:
        return f"the novelty {gate.novelty:g} is above {gate.novelty_limit:g}"
    if not gate.trust >= gate.trust_limit:
        return f"the trust {gate.trust:g} is below {gate.trust_limit:g}"
    return ""

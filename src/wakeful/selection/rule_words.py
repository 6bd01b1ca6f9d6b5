"""A learned rule in words: what it asks of an event, in the domain's own names and units."""

from __future__ import annotations

from wakeful.contracts.grounds import Ask, HeardRule
from wakeful.selection.features import Encoder

_HIGHEST_CRITICALITY = 3.0


class RuleWords:
    """Words for the rules of one domain's models.

    Args:
        encoder: the domain's, as it was when the model version was fitted.
    """

    def __init__(self, encoder: Encoder) -> None:
        self._names = encoder.columns
        self._units: dict[int, tuple[float, float]] = {encoder.criticality: (0.0, 1.0 / _HIGHEST_CRITICALITY)}
        """For each column that holds a number: the value at 0, and what a unit of the value is there."""
        for _, field, start, places, scale in encoder.fields:
            if not places:
                self._units.update({start + index: (field.low, scale) for index in range(max(1, field.size))})

    def rule(self, rule: HeardRule) -> str:
        """What the rule asks, all of which holds for the event."""
        return " and ".join(self.ask(each) for each in rule.asks) or "none of a list's rules holds"

    def ask(self, ask: Ask) -> str:
        """One clause: a category, a number against a limit, or a number shifted by another against a limit."""
        name = self._names[ask.column]
        if ask.column not in self._units and ask.other < 0:
            return self._yes_or_no(name, ask.above)
        low, unit = self._unit(ask.column)
        limit = ask.limit / unit + low
        said = name
        if ask.other >= 0:
            other_low, other_unit = self._unit(ask.other)
            slope = ask.slope * other_unit / unit
            limit += slope * other_low
            said += f" {'+' if slope >= 0.0 else '−'} {abs(slope):.3g} × {self._names[ask.other]}"
        return f"{said} {'>' if ask.above else '≤'} {limit:.4g}"

    def _unit(self, column: int) -> tuple[float, float]:
        low, unit = self._units.get(column, (0.0, 1.0))
        return low, unit or 1.0

    @staticmethod
    def _yes_or_no(name: str, holds: bool) -> str:
        field, is_value, value = name.partition("=")
        if is_value:
            return f"{field} is {value}" if holds else f"{field} is not {value}"
        if name.endswith(" missing"):
            return name.removesuffix(" missing") + (" is missing" if holds else " is known")
        if name.endswith(" other"):
            return name.removesuffix(" other") + (" is no declared value" if holds else " is a declared value or missing")
        if "#" in name:
            return f"{name} (hashed)" if holds else f"not {name} (hashed)"
        return f"{name} is set" if holds else f"no {name}"

"""A recorded result read without its treatment's code: the type, the sentence, and every other field in words."""

from __future__ import annotations

import msgspec

from wakeful.facts.values import Raw, Value


def result_says(result: Raw) -> str:
    """The result's one sentence for a person; empty where it has none."""
    says = result_fields(result).get("says", "")
    return says if isinstance(says, str) else ""


def result_fields(result: Raw) -> dict[str, Value]:
    """The result's fields as plain data. What is not a JSON object has none."""
    try:
        value = msgspec.json.decode(bytes(result))
    except msgspec.DecodeError:
        return {}
    return value if isinstance(value, dict) else {}


def in_words(value: Value, digits: int = 3) -> str:
    """Plain data as a person reads it: numbers to ``digits`` significant digits, lists with commas, mappings as name = value.

    >>> in_words({"joint": "J3", "current_a": 2.34567, "ok": False})
    'joint = J3, current_a = 2.35, ok = no'
    >>> in_words([18_812.4, 99.96])
    '18800, 100'
    """
    if value is None:
        return "unknown"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        rounded = float(f"{value:.{digits}g}")
        # written out where a person would: 18800, not 1.88e+04
        return f"{rounded:.0f}" if 100 <= abs(rounded) < 1e9 else f"{rounded:.{digits}g}"
    if isinstance(value, dict):
        return ", ".join(f"{name} = {in_words(entry, digits)}" for name, entry in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(in_words(entry, digits) for entry in value)
    return str(value)

"""Names, numbers and units as sentences say them. Text from the world is quoted in short, never followed."""

from __future__ import annotations

from wakeful.facts.events import Event
from wakeful.facts.values import Field

#: What the end of a field's name says of its unit (the house writes units into names).
UNITS: dict[str, str] = {
    "mps2": "m/s²",
    "mps": "m/s",
    "dps": "°/s",
    "degps": "°/s",
    "radps": "rad/s",
    "m": "m",
    "mm": "mm",
    "cm": "cm",
    "s": "s",
    "ms": "ms",
    "deg": "°",
    "rad": "rad",
    "c": "°C",
    "degc": "°C",
    "k": "K",
    "a": "A",
    "ma": "mA",
    "v": "V",
    "w": "W",
    "wh": "Wh",
    "n": "N",
    "nm": "N·m",
    "hz": "Hz",
    "pct": "%",
    "percent": "%",
    "kg": "kg",
    "bar": "bar",
    "pa": "Pa",
    "rpm": "rpm",
    "steps": "steps",
}

_SPANS = ((86_400.0, "d"), (3_600.0, "h"), (60.0, "min"), (1.0, "s"))


def brief(text: str, limit: int = 60) -> str:
    """Text from the world in one line of at most ``limit`` characters. It is quoted as data, never followed.

    >>> brief("a\\n  b"), brief("x" * 9, 5)
    ('a b', 'xxxx…')
    """
    # cut before splitting: a field may be megabytes long
    line = " ".join(text[: 4 * limit].split())
    return line if len(line) <= limit else line[: limit - 1] + "…"


def unit(name: str) -> str:
    """The unit that a field's name ends in, or nothing."""
    head, _, tail = name.rpartition("_")
    return UNITS.get(tail.lower(), "") if head else ""


def quantity(name: str, value: float, digits: int = 3) -> str:
    """A number with the unit of its field.

    >>> quantity("distance_m", 1.2345), quantity("tilt_deg", 7.0), quantity("silent_s", 18_812.0)
    ('1.23 m', '7°', '18800 s')
    """
    sign = unit(name)
    said = figure(value, digits)
    return said + sign if sign in ("°", "%") else f"{said} {sign}".rstrip()


def figure(value: float, digits: int = 3) -> str:
    """A number to so many significant digits, written out where a person would.

    >>> figure(0.12345), figure(99.96), figure(18_812.0), figure(3e12)
    ('0.123', '100', '18800', '3e+12')
    """
    rounded = float(f"{value:.{digits}g}")
    return f"{rounded:.0f}" if 100 <= abs(rounded) < 1e9 else f"{rounded:.{digits}g}"


def bare(name: str) -> str:
    """A field's name as a sentence says it, without its unit: ``distance_m`` is "distance"."""
    return brief((name.rpartition("_")[0] if unit(name) else name).replace("_", " "), 40)


def valued(name: str, value: Field) -> str:
    """A field's value as a sentence says it, with the unit that the name carries."""
    if value is None:
        return "unknown"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return brief(value) or "empty"
    if isinstance(value, tuple):
        return f"({', '.join(f'{figure(each)}' for each in value)})" if len(value) <= 3 else f"({len(value)} numbers)"
    return quantity(name, value)


def worded(name: str, value: Field) -> str:
    """A field as a sentence says it.

    >>> worded("distance_m", 1.5), worded("state", "unstable"), worded("safe", False)
    ('distance 1.5 m', 'state unstable', 'safe no')
    """
    return f"{bare(name)} {valued(name, value)}"


def span(seconds: float) -> str:
    """A length of time as a person says it.

    >>> span(0.25), span(90), span(7200), span(200_000)
    ('0.25 s', '1.5 min', '2 h', '2.3 d')
    """
    for size, word in _SPANS:
        if abs(seconds) >= size:
            return f"{seconds / size:.2g} {word}" if seconds < 10 * size else f"{seconds / size:.0f} {word}"
    return f"{seconds:.2g} s"


def ago(seconds: float) -> str:
    """When something recalled was, by the age that its stamp gives; another recording's clock may give one below zero.

    >>> ago(90.0), ago(0.0), ago(-3.0)
    ('1.5 min ago', 'at the same time', 'by another clock')
    """
    if seconds > 0.0:
        return f"{span(seconds)} ago"
    return "at the same time" if seconds == 0.0 else "by another clock"


def counted(count: int, thing: str, most: int | None = None) -> str:
    """How many of a thing; "at least" so many where the count went no further than ``most``.

    >>> counted(1, "sighting"), counted(8, "case", 8)
    ('1 sighting', 'at least 8 cases')
    """
    return f"{'at least ' if count == most else ''}{count} {thing}{'' if count == 1 else 's'}"


def percent(share: float) -> str:
    """A probability as a person reads it: whole per cents, finer near the ends, and never rounded to certainty.

    >>> percent(0.123), percent(0.0042), percent(0.9987), percent(0.99999)
    ('12 %', '0.4 %', '99.9 %', '> 99.9 %')
    """
    if 0.01 <= share <= 0.99 or share in (0.0, 1.0):
        return f"{100 * share:.0f} %"
    if share > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if share < 0.001 else f"{100 * share:.1f} %"


def subject(event: Event) -> str:
    """What a sentence is about, in a word: whoever reads a result has read what registration says of the event.

    What the treatment found follows at once.
    """
    return brief(event.entity) or event.kind.replace("_", " ") or "something"

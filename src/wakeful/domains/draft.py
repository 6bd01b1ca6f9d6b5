"""A domain drafted from a recording: a TOML file that loads and runs as it is, for a person to correct."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from wakeful.contracts.bridge import Peek
from wakeful.domains.quoting import alike, comment, pattern, text, texts, word
from wakeful.domains.survey import Channel, Survey, survey
from wakeful.facts.events import Observation
from wakeful.facts.time import to_s

Lines = Iterator[str]


def draft(observations: Iterable[Observation], name: str = "my_robot", peek: Peek | None = None) -> str:
    """The TOML of a domain for recordings like this one.

    Args:
        observations: the recording; its beginning is enough.
        name: what the domain is to be called.
        peek: the bridge's look at the source, so that the domain recognises others of its kind.

    Returns:
        TOML with comments, which loads and runs on the recording as it is. It proposes; which flags are outcomes and which
        changes matter only a person knows.
    """
    seen = survey(observations)
    labels = _labels(seen)
    parts = (_head(name, seen, peek), _outcomes(seen, labels), _fields(seen, labels), _detectors(seen, labels))
    return "\n".join([*(line for part in parts for line in part), *_guidelines(seen, labels)])


def _head(name: str, seen: Survey, peek: Peek | None) -> Lines:
    source = comment(Path(seen.source).name) or "a recording"
    yield f"# Drafted by `wakeful new domain` from {source}: read it, correct it, and count `version` up when you change it."
    yield f"name = {text(word(name))}"
    yield "version = 1"
    yield 'says = "What this robot is and does, in one line"'
    yield f"robot = {text(seen.robot or 'robot')}"
    telling = [*_labels(seen), *(each.channel for topic in seen.topics for each in seen.measures(topic)[:2])] or list(
        seen.channels
    )
    channels = [pattern(channel) for channel in telling[:4]]
    bridges = f"bridges = [{text(peek.bridge)}], " if peek is not None else ""
    yield "# A source is taken for one of this domain if all of this holds: name the channels that only this robot has."
    yield f"recognise = {{ {bridges}channels = {texts(channels)} }}"
    yield ""


def _outcomes(seen: Survey, labels: dict[str, str]) -> Lines:
    yield "# What the world may show later, and how long an event waits for it: choose by how long a consequence takes."
    known = ["none", *labels.values()] if labels else ["none", "intervention"]
    yield f'outcome = {{ labels = {texts(known)}, within_s = {_within_s(seen)!r}, scope = "robot" }}'
    if labels:
        yield "# Flags that are seldom up. Strike those that are no outcome. A blank in a flag is taken as unknown."
    else:
        yield "# No flag was seen that is seldom up. Without outcomes nothing is validated and nothing learned; name a channel:"
        yield '# [[outcomes]]\n# channel = "topic/name"\n# label = "intervention"'
    for channel, label in labels.items():
        flag = seen.channels[channel]
        yield "[[outcomes]]"
        yield f"channel = {text(pattern(channel))}  # up {flag.up_share:.1%} of the time, rose {flag.up_times} times"
        yield f"label = {text(label)}"
    yield ""


def _fields(seen: Survey, labels: dict[str, str]) -> Lines:
    yield "# What a learner sees of an event: numbers are scaled from low..high to 0..1. `channel` puts the last value of a"
    yield "# channel beside every event, `since` the seconds since it changed."
    yield "[fields]"
    made = {"deviation": "{ high = 12.0 }", "since_same_s": "{ high = 120.0 }", "recent_entity": "{ high = 20.0 }"}
    for label in labels.values():
        made[f"since_{label}_s"] = "{ high = 120.0 }"
        made[f"recent_{label}"] = "{ high = 20.0 }"
    for cycle in seen.cycles()[:1]:
        made.setdefault("cycle_s", f"{{ since = {text(cycle.channel)}, high = 60.0 }}")
    for each in [each for topic in seen.topics for each in seen.measures(topic)][:6]:
        ends = f"low = {float(f'{each.low:.4g}')!r}, high = {float(f'{each.high:.4g}')!r}"
        if "{" not in each.channel and float(f"{each.low:.4g}") < float(f"{each.high:.4g}"):
            made.setdefault(word(each.name), f"{{ channel = {text(each.channel)}, {ends} }}")
    yield from (f"{field} = {says}" for field, says in made.items())
    yield ""


def _detectors(seen: Survey, labels: dict[str, str]) -> Lines:
    cycle = seen.cycles()[:1]
    by_phase = "".join(f"cycle = {text(pattern(each.channel))}, phase_s = 5.0, memory = 200.0, " for each in cycle)
    for topic in seen.topics:
        if patterns := list(dict.fromkeys(alike(topic, each.name) for each in seen.measures(topic))):
            yield "# Numbers that leave the band they usually stay in; those of one topic within 5 s are one event."
            settings = f"settings = {{ {by_phase}width = 5.0, together_s = 5.0 }}"
            yield from _detect("band", f"{word(topic)}_unusual", patterns, settings)
            for each in cycle:
                if each.topic == topic:
                    yield "# A piece of work unlike those before it."
                    yield from _detect(
                        "cycle", "cycle_unlike", patterns, f"settings = {{ cycle = {text(pattern(each.channel))} }}"
                    )
    for channel, label in labels.items():
        yield "# An outcome is also something to think about when it comes."
        lasting = 'settings = { on = "rising", lasting = true, first = true }'
        yield from _detect("edge", label, [pattern(channel)], "criticality = 2", lasting)
    for topic in seen.topics:
        if changing := [pattern(each.channel) for each in _changing(seen, topic) if each.channel not in labels]:
            yield "# Flags, categories and codes that change."
            yield from _detect("edge", f"{word(topic)}_changed", changing)
    for each in seen.channels.values():
        if each.is_text:
            beside = (other.name for other in seen.channels.values() if other.topic == each.topic)
            level = next((name for name in beside if "level" in name.lower() or "severity" in name.lower()), "level")
            yield "# Log lines from level 30 (warning) on; lines of one wording are one condition."
            yield from _detect(
                "text", f"{word(each.topic)}_said", [pattern(each.channel)], f"settings = {{ level = {text(level)} }}"
            )
        if each.is_list_of_conditions:
            roles = ", ".join(f"{role} = {text(member)}" for role, member in _roles(each))
            yield "# A list of what is wrong, sent again and again."
            yield from _detect("conditions", f"{word(each.name)}_listed", [pattern(each.channel)], f"settings = {{ {roles} }}")
    yield "# A topic that is not heard for long."
    topics = [f"{pattern(topic)}/*" for topic, heard in seen.topics.items() if heard.count > 20]
    yield from _detect("silence", "silent", topics or ["*"], 'entity = "{topic}"', "criticality = 1")


def _guidelines(seen: Survey, labels: dict[str, str]) -> Lines:
    yield "# Which treatment for which event, and why. `expect` would say which outcome: you know your robot."
    changed = [
        f"{word(each.topic)}_changed" for topic in seen.topics for each in _changing(seen, topic) if each.channel not in labels
    ]
    unusual = [f"{word(topic)}_unusual" for topic in seen.topics if seen.measures(topic)]
    told = [f"{word(each.topic)}_said" for each in seen.channels.values() if each.is_text]
    told += [f"{word(each.name)}_listed" for each in seen.channels.values() if each.is_list_of_conditions]
    for treat, kinds, because in (
        ("causal_analysis", [*labels.values()], "what led to it is worth knowing before it comes again"),
        ("comparison", [*unusual, "cycle_unlike"], "what is unusual is best compared with what was usual"),
        ("diagnosis", [*told, "silent"], "the robot reports a fault, or a part of it has fallen silent"),
        ("description", changed, "a change of state is stated and remembered"),
    ):
        if kinds:
            yield f"[[guideline]]\ntreat = {text(treat)}\nwhen = {{ kind = {texts(dict.fromkeys(kinds))} }}"
            yield f"because = {text(because)}\n"


def _detect(detector: str, kind: str, channels: list[str], *more: str) -> Lines:
    yield f"[[detect]]\ndetector = {text(detector)}\nkind = {text(kind)}\nchannels = {texts(channels)}"
    yield from more
    yield ""


def _labels(seen: Survey) -> dict[str, str]:
    """A label of its own for each flag that may be an outcome, by channel."""
    labels: dict[str, str] = {}
    for flag in seen.outcome_flags():
        short = word(flag.name.rpartition(".")[2])
        labels[flag.channel] = short if short not in ("none", *labels.values()) else word(f"{flag.topic}_{flag.name}")
    return {channel: label for channel, label in labels.items() if list(labels.values()).count(label) == 1}


def _changing(seen: Survey, topic: str) -> list[Channel]:
    return [each for each in seen.channels.values() if each.topic == topic and each.is_state]


def _roles(listed: Channel) -> Iterator[tuple[str, str]]:
    for role, hints in (("type", ("type",)), ("level", ("level", "severity")), ("text", ("description", "message", "text")),
                        ("references", ("reference",))):  # fmt: skip
        for hint in hints:
            member = next((member for member in listed.members if hint in member.lower()), None)
            if member is not None:
                yield role, member
                break


def _within_s(seen: Survey) -> float:
    """A minute, or a tenth of a short recording."""
    first = min((heard.first_ns for heard in seen.topics.values()), default=0)
    last = max((heard.last_ns for heard in seen.topics.values()), default=0)
    return float(f"{min(max(to_s(last - first) / 10, 1.0), 60.0):.2g}")

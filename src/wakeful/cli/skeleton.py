"""The files that `wakeful new treatment` writes: a package with one treatment, its test, and how to install it."""

from __future__ import annotations

from string import Template

_PYPROJECT = Template("""\
[build-system]
requires = ["hatchling>=1.27"]
build-backend = "hatchling.build"

[project]
name = "wakeful-$dashed"
version = "0.1.0"
description = "The treatment $name for wakeful."
requires-python = ">=3.11"
dependencies = ["wakeful>=$version"]

# Every mind on a machine where this package is installed may choose the treatment; `wakeful treatments` lists it.
[project.entry-points."wakeful.treatments"]
$name = "wakeful_$name:$name"

[tool.hatch.build.targets.wheel]
packages = ["src/wakeful_$name"]

[dependency-groups]
dev = ["pytest>=8.3"]

[tool.pytest.ini_options]
pythonpath = ["src"]
""")

_TREATMENT = Template('''\
"""$title: say in one sentence what it concludes, and for which events it is meant.

Source: name the paper, standard or manual that the method comes from.
"""

from __future__ import annotations

import wakeful


class $type(wakeful.Result, frozen=True, kw_only=True, tag="$name"):
    """What it concludes, as typed fields. ``says``, ``confidence``, ``rests_on`` and ``would_change`` are there already."""

    seen_before: int = 0


@wakeful.treatment(
    version=1,  # count up when a change makes it ask for something else: waiting processes are then restarted, by name
    result=$type,
    says="What it does and for which events: a reasoner and the guidelines choose by this sentence.",
)
async def $name(event: wakeful.Event, mind: wakeful.MindView) -> $type:
    """Think about one event.

    Everything that is awaited comes from ``mind``, and each await is a place where a more urgent event may come first and
    where the process can be taken up again after a crash. Between two awaits the code must depend on the event and the
    answers alone: no clock, no randomness, no files.

    Other things to await: ``mind.evidence(topic, key, within_s)``, ``mind.deliberate(question)`` in delib mode,
    ``mind.ask(role, question, within_s)``, ``mind.treat(name, event)``, ``mind.call(function, key, within_s)``.
    """
    await mind.work(1)
    past = await mind.recall(wakeful.Query(event=event.id, entity=event.entity, limit=5))
    forecast = mind.forecast()
    met = f"{len(past)} times before" if past else "for the first time"
    return $type(
        says=f"{event.entity or event.kind} was met {met}.",
        confidence=0.5 if past else 0.1,  # be honest: with nothing to go on, 0.1 or less
        rests_on=(f"event {event.id}", *(f"event {each.event}" for each in past)),
        would_change=("another sighting of it",),
        forecast=forecast,  # the outcome label that the world is expected to show; it will be validated
        seen_before=len(past),
    )
''')

_TEST = Template('''\
"""$name keeps the contract of a treatment, in every mode, and concludes what it should."""

from __future__ import annotations

from wakeful import Event
from wakeful.domains import load
from wakeful.facts.asking import Episode
from wakeful.facts.time import Stamp, to_ns
from wakeful.testing import Script, ScriptedMind, check_treatment
from wakeful_$name import $type, $name

DOMAIN = load("service_robot").spec
EVENT = Event(
    id="e2",
    kind="object",
    entity="box 7",
    source="test",
    position=2,
    stamp=Stamp(source_ns=to_ns(100.0), received_ns=to_ns(100.0)),
    fields={"category": "obstacle", "state": "unstable"},
)
BEFORE = Episode(event="e1", kind="object", entity="box 7", at_ns=to_ns(40.0), likeness=0.9, treatment="description")


def test_it_keeps_the_contract() -> None:
    check_treatment($name, EVENT, DOMAIN, Script(now_s=100.0, episodes=(BEFORE,)))


def test_it_knows_what_it_has_met_before() -> None:
    result = ScriptedMind(DOMAIN, "auto", Script(now_s=100.0, episodes=(BEFORE,))).run($name, EVENT)
    assert isinstance(result, $type)
    assert result.seen_before == 1
''')

_README = Template("""\
# wakeful-$dashed

The treatment `$name` for [wakeful](https://pypi.org/project/wakeful/).

```
pip install -e . pytest     # in the environment of the robot's mind
pytest                      # the contract, and what it concludes
wakeful treatments          # lists it
```

A domain lets it be chosen by a guideline, or deliberation by its `says`:

```toml
[[guideline]]
treat = "$name"
because = "why these events need it"
when = { kind = "object" }
```
""")


def skeleton(name: str, version: str) -> dict[str, str]:
    """The files of a new treatment's package.

    Args:
        name: the treatment's, an identifier in lower case.
        version: of the wakeful that it is written for.

    Returns:
        their text by their path in the package's folder.
    """
    words = {
        "name": name,
        "dashed": name.replace("_", "-"),
        "type": "".join(part.capitalize() for part in name.split("_")),
        "title": name.replace("_", " ").capitalize(),
        "version": version,
    }
    files = {
        "pyproject.toml": _PYPROJECT,
        f"src/wakeful_{name}/__init__.py": _TREATMENT,
        f"tests/test_{name}.py": _TEST,
        "README.md": _README,
    }
    return {path: text.substitute(words) for path, text in files.items()}

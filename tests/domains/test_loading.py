"""Domains are found by name and path, and a bad one says where it is wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from wakeful import domains
from wakeful.contracts.bridge import Peek
from wakeful.domains import DomainError, load, names, recognise
from wakeful.domains.recognition import score
from wakeful.domains.toml import KNOWLEDGE, parse_spec
from wakeful.facts.domain import Recognise

GOOD = """
name = "mine"
version = 1
says = "a test"
[fields.load]
high = 2.0
[outcome]
labels = ["none", "stop"]
[[detect]]
detector = "band"
kind = "odd"
"""


def test_every_built_in_domain_loads_and_carries_its_own_name() -> None:
    for name in names():
        assert load(name).spec.name == name


def test_a_users_toml_is_loaded_by_its_path(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(GOOD)
    domain = load(str(tmp_path / "mine.toml"))
    assert domain.spec.detect[0].kind == "odd"
    assert domain.detectors() == {}
    assert domain.simulate(0) is None


def test_a_users_folder_brings_detectors_and_a_simulator(tmp_path: Path) -> None:
    (tmp_path / "domain.toml").write_text(GOOD)
    (tmp_path / "detectors.py").write_text("DETECTORS = {'own': lambda spec, domain: None}\n")
    (tmp_path / "simulate.py").write_text("def simulate(seed):\n    yield seed\n")
    domain = load(str(tmp_path))
    assert set(domain.detectors()) == {"own"}
    simulated = domain.simulate(7)
    assert simulated is not None
    assert next(simulated) == 7


BUILT_IN = Path(domains.__file__).parent


@pytest.mark.parametrize("path", sorted(BUILT_IN.glob("*/domain.toml")), ids=lambda path: path.parent.name)
def test_a_built_in_domain_is_under_sixty_lines_that_a_person_can_read(path: Path) -> None:
    assert len(path.read_text().splitlines()) < 60
    known = path.with_name(KNOWLEDGE)
    lines = [*path.read_text().splitlines(), *(known.read_text().splitlines() if known.is_file() else [])]
    assert max(len(line) for line in lines) <= 200


KNOWN = """
[[guideline]]
treat = "memory"
because = "it may be light"
when = { load = "<1" }
[[fault]]
name = "worn"
prior = 0.1
causes = { odd = 0.5 }
"""


def test_what_is_known_may_stand_in_a_file_beside_the_domain(tmp_path: Path) -> None:
    (tmp_path / "domain.toml").write_text(GOOD)
    (tmp_path / KNOWLEDGE).write_text(KNOWN)
    for path in (tmp_path, tmp_path / "domain.toml"):
        spec = load(str(path)).spec
        assert ([each.treat for each in spec.guideline], [each.name for each in spec.fault]) == (["memory"], ["worn"])
        assert spec.detect[0].kind == "odd"


@pytest.mark.parametrize(
    ("domain", "known", "says"),
    [
        (GOOD, KNOWN.replace("prior = 0.1", "prior = 7.0"), r"knowledge\.toml: fault worn: prior 7\.0 is not a probability"),
        (GOOD, KNOWN.replace("load =", "lod ="), r"knowledge\.toml: guideline 1 \(memory\): when\.lod: no such field"),
        (GOOD, KNOWN + "[[detect]]\ndetector = 'band'\nkind = 'x'\n", r"knowledge\.toml: Object contains unknown field `detect`"),
        (GOOD + KNOWN, KNOWN, r"knowledge\.toml: guideline: domain\.toml has this table too"),
        (GOOD.replace("high = 2.0", "high = -1.0"), KNOWN, r"domain\.toml: fields\.load: low"),
    ],
)
def test_a_mistake_names_the_one_of_the_two_files_that_has_it(tmp_path: Path, domain: str, known: str, says: str) -> None:
    (tmp_path / "domain.toml").write_text(domain)
    (tmp_path / KNOWLEDGE).write_text(known)
    with pytest.raises(DomainError, match=says):
        load(str(tmp_path))


def test_an_unknown_name_is_answered_with_the_names_there_are() -> None:
    with pytest.raises(DomainError, match="no domain 'nowhere'; use one of"):
        load("nowhere")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("version = 1", "version = "), "not TOML"),
        (("version = 1", 'version = "one"'), r"Expected `int`, got `str` - at `\$.version`"),
        (("version = 1", "versio = 1"), "unknown field `versio`|missing required field"),
        (("high = 2.0", "high = -1.0"), r"fields\.load: low 0\.0 is not below high -1\.0; give"),
        (('kind = "odd"', 'kind = "odd"\ncriticality = 7'), r"detect 1 \(odd\): criticality 7; use 0 routine"),
        (('labels = ["none", "stop"]', "labels = []"), "outcome.labels: needs at least one label"),
        (("[[detect]]", '[[outcomes]]\nchannel = "a/b"\nlabel = "crash"\n[[detect]]'), "outcomes 1: label 'crash' is not in"),
        (
            ("[[detect]]", '[[guideline]]\ntreat = "memory"\nbecause = "x"\nwhen = {lod = ">1"}\n[[detect]]'),
            r"when\.lod: no such field",
        ),
        (
            ("[[detect]]", '[[guideline]]\ntreat = "memory"\nbecause = "x"\nwhen = {load = ">x"}\n[[detect]]'),
            "compares with no number",
        ),
        (
            ("[[detect]]", '[[hazard]]\nname = "x"\nseverity = 9\nexposure = 1.0\nlikelihood = 1.0\n[[detect]]'),
            "hazard x: severity 9",
        ),
        (
            (
                "[[detect]]",
                '[[hazard]]\nname = "x"\nseverity = 1\nexposure = 1.0\nlikelihood = 1.0\noutcomes = ["bang"]\n[[detect]]',
            ),
            "hazard x: outcome 'bang' is not in outcome.labels; use one of none, stop",
        ),
    ],
)
def test_a_bad_toml_is_refused_with_its_place_and_a_way_out(change: tuple[str, str], says: str) -> None:
    with pytest.raises(DomainError, match=says) as refused:
        parse_spec(GOOD.replace(*change), "mine.toml")
    assert str(refused.value).startswith("mine.toml: ")


def test_an_absent_or_binary_file_is_one_clear_error(tmp_path: Path) -> None:
    with pytest.raises(DomainError, match="cannot be read"):
        load(str(tmp_path / "absent.toml"))
    (tmp_path / "binary.toml").write_bytes(bytes(range(256)))
    with pytest.raises(DomainError, match="not TOML"):
        load(str(tmp_path / "binary.toml"))


def test_a_domain_whose_code_does_not_import_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "domain.toml").write_text(GOOD)
    (tmp_path / "detectors.py").write_text("import nothing_of_that_name\n")
    with pytest.raises(DomainError, match=r"detectors\.py: does not import"):
        load(str(tmp_path))


def test_a_more_particular_domain_scores_higher_and_a_missing_channel_excludes() -> None:
    peek = Peek(bridge="xlsx", channels=("row/Current_J0", "row/cycle"))
    path = Path("arm.xlsx")
    general = score(Recognise(bridges=("xlsx",)), peek, path)
    particular = score(Recognise(bridges=("xlsx",), channels=("row/Current_J*", "odom/*|*/cycle")), peek, path)
    assert particular > general > 0
    assert score(Recognise(bridges=("xlsx",), channels=("row/speed",)), peek, path) == 0
    assert score(Recognise(bridges=("mcap",)), peek, path) == 0
    assert score(Recognise(suffixes=(".csv",)), peek, path) == 0
    assert score(Recognise(), peek, path) == 0


def test_a_source_like_no_domain_is_not_recognised() -> None:
    assert recognise(Peek(bridge="no_such_bridge", channels=("a/b",)), Path("x.bin")) is None


def test_an_incident_that_is_no_label_is_a_mistake_and_every_domain_has_one_at_least() -> None:
    with pytest.raises(DomainError, match=r"outcome\.incidents: 'crash' is not in outcome\.labels"):
        parse_spec(GOOD.replace('labels = ["none", "stop"]', 'labels = ["none", "stop"]\nincidents = ["crash"]'), "mine.toml")
    for name in names():
        outcome = load(name).spec.outcome
        assert outcome.incidents or outcome.labels[1:]
        assert outcome.labels[0] not in outcome.incidents

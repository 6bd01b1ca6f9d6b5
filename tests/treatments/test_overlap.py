from hypothesis import given

from tests.treatments.worlds import episode, event
from tests.treatments.worlds import fields as any_fields
from wakeful.facts.domain import FieldSpec
from wakeful.facts.values import Field
from wakeful.treatments.overlap import overlap, worth


@given(any_fields, any_fields)
def test_an_overlap_is_symmetric_and_between_nothing_and_everything(a: dict[str, Field], b: dict[str, Field]) -> None:
    one, other = overlap(a, b, {}), overlap(b, a, {})
    assert 0.0 <= one.share <= 1.0
    assert abs(one.share - other.share) < 1e-5
    assert set(one.shared) == set(other.shared)
    assert sorted((*one.shared, *one.differing, *one.lacking)) == sorted(
        name for name in {*a, *b} if name not in ("channel", "topic")
    )


def test_everything_overlaps_with_itself_wholly() -> None:
    here: dict[str, Field] = {"state": "hot", "load": 0.4, "trace": (1.0, 2.0), "on": True}
    assert overlap(here, here, {}).share == 1.0


def test_numbers_are_compared_on_the_fields_declared_range_where_both_lie_in_it() -> None:
    spec = {"t": FieldSpec(low=0.0, high=100.0)}
    assert overlap({"t": 20.0}, {"t": 30.0}, spec).share == 0.9
    assert overlap({"t": 20.0}, {"t": 300.0}, spec).share < 0.1


def test_vectors_are_compared_number_by_number_and_only_of_equal_length() -> None:
    assert overlap({"v": (1.0, 2.0)}, {"v": (1.0, 1.0)}, {}).share == 0.75
    assert overlap({"v": (1.0, 2.0)}, {"v": (1.0,)}, {}).share == 0.0


def test_where_a_value_comes_from_is_not_what_it_is() -> None:
    assert overlap({"channel": "a", "x": 1.0}, {"channel": "b", "x": 1.0}, {}).share == 1.0


def test_a_case_without_attributes_is_worth_its_kind() -> None:
    assert worth(event(), episode("a", 1.0), {}) == 1.0
    assert worth(event(), episode("a", 1.0, kind="object"), {}) == 0.0
    assert worth(event(state="hot"), episode("a", 1.0, kind="object", state="hot"), {}) == 0.5
    assert worth(event(state="hot"), episode("a", 1.0, state="cold"), {}) == 0.0

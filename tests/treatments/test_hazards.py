import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.treatments.worlds import DOMAIN, event
from wakeful.facts.domain import Hazard
from wakeful.facts.events import Context
from wakeful.treatments.hazards import RATINGS, assess, circumstances, rating, shows_as

severities, chances = st.integers(1, 4), st.floats(0.0, 1.0)


@given(severities, severities, chances, chances)
def test_what_is_worse_and_likelier_is_never_rated_lower(severity: int, other: int, harm: float, more: float) -> None:
    (low, high), (seldom, often) = sorted((severity, other)), sorted((harm, more))
    assert RATINGS.index(rating(low, seldom)) <= RATINGS.index(rating(high, often))


def test_conditions_see_the_context_and_the_events_own_field_where_both_have_one() -> None:
    met = event(load=0.9, context=Context(zone="hall", safety=True, fields={"load": 0.1, "speed": 1.0}))
    seen = circumstances(met)
    assert (seen["load"], seen["speed"], seen["zone"], seen["safety"], seen["kind"]) == (0.9, 1.0, "hall", True, "current_high")


@pytest.mark.parametrize(
    ("name", "outcomes", "labels"),
    [
        ("stop", (), ("stop",)),
        ("falls", (), ()),
        ("falls", ("drop", "unheard of"), ("drop",)),
    ],
)
def test_a_hazard_is_learned_only_from_labels_that_are_known_to_show_it(
    name: str, outcomes: tuple[str, ...], labels: tuple[str, ...]
) -> None:
    assert shows_as(Hazard(name=name, severity=2, exposure=1.0, likelihood=0.1, outcomes=outcomes), DOMAIN) == labels


def test_the_rating_at_the_intervals_upper_end_is_no_better_than_at_the_mean() -> None:
    for row in assess(event(state="unstable"), DOMAIN, (), 4.0, 0.9):
        assert RATINGS.index(row.rating_at_worst) >= RATINGS.index(row.rating)
        assert row.low < row.likelihood < row.high

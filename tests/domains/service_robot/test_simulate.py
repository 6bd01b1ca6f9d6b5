"""The tour: repeatable, mostly uneventful, true to the distributions it is made of, and turning its outcomes round at length."""

from __future__ import annotations

from collections import Counter
from itertools import islice, pairwise

import pytest

from wakeful.contracts.detector import Found, Offered, Shown
from wakeful.contracts.domain import Domain
from wakeful.domains import load
from wakeful.domains.service_robot.simulate import FIRST_TURN_S, START_NS, simulate
from wakeful.domains.service_robot.world import CATEGORIES, CONTEXTS, HISTORIES, LOCATIONS, PLACES, ROUTES, STATES
from wakeful.facts.events import Observation, Relation, event_id
from wakeful.facts.time import to_ns
from wakeful.registration import SpecRegistrar

LENGTH = 120_000


@pytest.fixture(scope="module")
def domain() -> Domain:
    return load("service_robot")


@pytest.fixture(scope="module")
def tour() -> list[Observation]:
    return list(islice(simulate(7), LENGTH))


@pytest.fixture(scope="module")
def seen(domain: Domain, tour: list[Observation]) -> list[tuple[Observation, Found | Shown | Offered]]:
    detectors = [domain.detectors()[spec.detector](spec, domain.spec) for spec in domain.spec.detect]
    return [(observation, found) for observation in tour for detector in detectors for found in detector.observe(observation)]


def test_the_same_seed_gives_the_same_tour_and_another_seed_another() -> None:
    first, again, other = (list(islice(simulate(seed), 3_000)) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_positions_count_without_gaps_and_time_never_runs_back(tour: list[Observation]) -> None:
    assert [observation.position for observation in tour] == list(range(LENGTH))
    assert all(a.at_ns <= b.at_ns for a, b in pairwise(tour))


def test_most_observations_are_repeats_and_no_event(seen: list[tuple[Observation, Found | Shown | Offered]]) -> None:
    events = [found for _, found in seen if isinstance(found, Found)]
    assert LENGTH / 200 < len(events) < LENGTH / 20


def test_events_are_distributed_as_in_experiment_1(seen: list[tuple[Observation, Found | Shown | Offered]]) -> None:
    events = [found for _, found in seen if isinstance(found, Found)]
    for name, shares in {
        "category": CATEGORIES,
        "location": LOCATIONS,
        "state": STATES,
        "route": ROUTES,
        "context": CONTEXTS,
    }.items():
        counted = Counter(found.fields[name] for found in events)
        for value, share in shares.items():
            assert counted[value] / len(events) == pytest.approx(share, abs=0.06), (name, value)
    loads = sorted(float(found.fields["load"]) for found in events)  # type: ignore[arg-type]
    assert loads[len(loads) // 2] == pytest.approx(0.5, abs=0.06)


def test_history_shows_in_position_and_identity_alone(seen: list[tuple[Observation, Found | Shown | Offered]]) -> None:
    position: dict[str, tuple[str, object]] = {}
    histories: Counter[str] = Counter()
    for _, found in seen:
        if isinstance(found, Found):
            before = position.get(found.entity)
            now = (found.zone, found.fields["position"])
            histories["none" if before is None else "unchanged" if before == now else "moved"] += 1
            position[found.entity] = now
            assert "history" not in found.fields
    for history, share in HISTORIES.items():
        assert histories[history] / histories.total() == pytest.approx(share, abs=0.06)


def test_every_event_carries_the_right_treatment_and_never_as_a_field(
    seen: list[tuple[Observation, Found | Shown | Offered]], domain: Domain
) -> None:
    events = [found for _, found in seen if isinstance(found, Found)]
    assert {found.truth_treatment for found in events} == set(domain.spec.treatments)
    assert all(set(found.fields) & {"truth", "truth_treatment", "history"} == set() for found in events)


def test_an_outcome_names_the_sighting_that_it_is_about_and_comes_5_to_60_s_later(
    seen: list[tuple[Observation, Found | Shown | Offered]],
) -> None:
    events = {observation.position: (observation, found) for observation, found in seen if isinstance(found, Found)}
    outcomes = [(observation, found) for observation, found in seen if isinstance(found, Shown)]
    assert len(outcomes) > 0.6 * len(events)
    for observation, shown in outcomes:
        assert shown.event_position is not None
        about, event = events[shown.event_position]
        assert event.entity == shown.entity
        assert to_ns(5) <= observation.at_ns - about.at_ns <= to_ns(62)


def test_outcomes_follow_the_state_at_first_and_turn_round_later(
    seen: list[tuple[Observation, Found | Shown | Offered]],
) -> None:
    events = {observation.position: found for observation, found in seen if isinstance(found, Found)}
    against: list[int] = []
    for observation, shown in seen:
        if isinstance(shown, Shown):
            assert shown.event_position is not None
            unwell = events[shown.event_position].fields["state"] != "normal"
            if unwell != (shown.label == "intervention"):
                against.append(observation.at_ns)
    assert against
    assert min(against) >= START_NS + to_ns(FIRST_TURN_S[0])


def test_a_device_that_is_not_right_gives_a_reading_later(seen: list[tuple[Observation, Found | Shown | Offered]]) -> None:
    events = {found.entity: found for _, found in seen if isinstance(found, Found)}
    readings = [found for _, found in seen if isinstance(found, Offered)]
    assert readings
    assert {reading.topic for reading in readings} == {"reading"}
    assert all(events[reading.key].fields["category"] == "device" for reading in readings)


def test_the_route_graph_joins_all_places(domain: Domain) -> None:
    neighbours: dict[str, set[str]] = {}
    for route in domain.spec.route:
        neighbours.setdefault(route.start, set()).add(route.end)
        neighbours.setdefault(route.end, set()).add(route.start)
    assert set(neighbours) == set(PLACES)
    reached, ahead = {"hall"}, ["hall"]
    while ahead:
        for place in neighbours[ahead.pop()] - reached:
            reached.add(place)
            ahead.append(place)
    assert reached == set(PLACES)


def test_the_registrar_computes_the_history_that_the_world_had(tour: list[Observation], domain: Domain) -> None:
    registrar = SpecRegistrar(domain, "d")
    place: dict[str, tuple[str, object]] = {}
    counted: Counter[tuple[str, Relation]] = Counter()
    for observation in tour:
        for event in registrar.observe(observation).events:
            before = place.get(event.entity)
            now = (event.context.zone, event.fields["position"])
            history = "none" if before is None else "unchanged" if before == now else "moved"
            counted[history, event.relation] += 1
            place[event.entity] = now
    assert {pair for pair, count in counted.items() if count > 0.002 * counted.total()} == {
        ("none", Relation.NEW),
        ("moved", Relation.MOVED),
        ("unchanged", Relation.CHANGED),
    }


def test_an_outcome_finds_the_event_that_it_is_about_and_a_reading_its_device(tour: list[Observation], domain: Domain) -> None:
    registrar = SpecRegistrar(domain, "d")
    registered = [registrar.observe(observation) for observation in tour]
    events = {
        event_id(event.robot, "d", event.position, event.kind, event.ordinal): event
        for each in registered
        for event in each.events
    }
    outcomes = [outcome for each in registered for outcome in each.outcomes]
    assert all(events[outcome.event].entity == outcome.entity for outcome in outcomes)
    assert all(events[outcome.event].at_ns < outcome.at_ns for outcome in outcomes)
    readings = [evidence for each in registered for evidence in each.evidence]
    assert {evidence.topic for evidence in readings} == {"reading"}

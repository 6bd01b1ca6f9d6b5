"""An excursion is one event; the band is learned, robust, and its own for each phase of a cycle."""

from __future__ import annotations

from random import Random

from tests.registration.watching import detector, founds, seen
from wakeful.contracts.detector import Found
from wakeful.facts.events import Phase


def noise(count: int, seed: int = 0) -> list[float]:
    random = Random(seed)
    return [random.gauss(10.0, 1.0) for _ in range(count)]


def test_an_excursion_is_one_event_however_long_it_lasts() -> None:
    found = founds(detector("band", gap_s=0.0), [*noise(200), *[30.0] * 20, *noise(50, 1), 30.0])
    assert [index for index, _ in found] == [200, 270]
    fields = found[0][1].fields
    assert fields["side"] == "above"
    deviation = fields["deviation"]
    assert isinstance(deviation, float)
    assert 15 < deviation < 30


def test_noise_alone_leaves_its_band_seldom() -> None:
    assert len(founds(detector("band", width=4.0, gap_s=0.0), noise(5000))) < 5


def test_a_lasting_excursion_is_raised_and_cleared() -> None:
    found = founds(detector("band", lasting=True, calm=2), [*noise(100), 30.0, 30.0, 10.0, 10.0, 10.0])
    assert [(index, item.phase) for index, item in found] == [(100, Phase.RAISED), (103, Phase.CLEARED)]


def test_a_value_near_the_edge_does_not_flicker() -> None:
    edge = [10.0 + 4.2 * sign for sign in (1, 1)] * 10
    wavering = [14.5, 13.3] * 10
    found = founds(detector("band", width=4.0, inner=0.7, gap_s=0.0), [*noise(500), *wavering, *edge])
    assert len(found) <= 1


def test_the_gap_between_events_is_kept() -> None:
    values = [*noise(100), *([30.0, 10.0, 10.0] * 10)]
    assert len(founds(detector("band", gap_s=60.0), values)) == 1
    assert len(founds(detector("band", gap_s=0.0), values)) == 10


def test_a_single_outlier_does_not_count_where_it_must_hold() -> None:
    assert founds(detector("band", hold=3), [*noise(100), 30.0, 10.0, 10.0, 30.0, 10.0]) == []
    assert [index for index, _ in founds(detector("band", hold=3), [*noise(100), 30.0, 30.0, 30.0])] == [102]


def test_a_lasting_change_of_level_becomes_usual() -> None:
    watcher = detector("band", memory=100.0, gap_s=0.0)
    random = Random(1)
    shifted = [random.gauss(20.0, 1.0) for _ in range(1500)]
    found = founds(watcher, [*noise(300), *shifted])
    assert found[0][0] == 300
    assert [index for index, _ in found if index > 1000] == []


def test_a_constant_channel_notices_its_first_change_and_does_not_stay_stuck() -> None:
    found = founds(detector("band", learn=20, memory=50.0, gap_s=0.0), [5.0] * 50 + [6.0] * 500 + [5.0, 6.0] * 20)
    assert found[0][0] == 50
    assert len(found) <= 3


def test_what_is_usual_in_one_phase_is_unusual_in_another() -> None:
    watcher = detector("band", ("t/x",), learn=10, cycle="t/cycle", phase_s=1.0, gap_s=0.0)
    random = Random(0)
    found = []
    for index in range(200):
        phase = index % 4
        value = (20.0 if phase == 1 else 0.0) + random.gauss(0, 0.1)
        value = 20.0 if index == 162 else value
        found += [index for _ in watcher.observe(seen(index, float(index), x=value, cycle=index // 4))]
    assert found == [162]


def test_while_the_work_is_paused_nothing_is_judged() -> None:
    watcher = detector("band", ("t/x",), pause=["t/stop"], gap_s=0.0)
    found = []
    for index, value in enumerate([*noise(100), *[50.0] * 5, 50.0]):
        found += [index for _ in watcher.observe(seen(index, float(index), x=value, stop=100 <= index < 105))]
    assert found == [105]


def test_channels_that_leave_together_are_one_event_of_the_farthest_out() -> None:
    watcher = detector("band", ("t/J*",), "J{number}", together_s=3.0, gap_s=0.0)
    found = []
    for index, value in enumerate([*noise(100), 30.0]):
        far = value if index < 100 else 90.0
        found += list(watcher.observe(seen(index, float(index), J0=value, J1=far, J2=noise(1)[0])))
    (only,) = found
    assert isinstance(only, Found)
    assert (only.entity, only.fields["joined"]) == ("J1", 2)


def test_one_sided_bands_look_at_their_side_only() -> None:
    values = [*noise(100), -20.0, 10.0, 10.0, 10.0, 40.0]
    assert [index for index, _ in founds(detector("band", sides="above", gap_s=0.0), values)] == [104]
    assert [index for index, _ in founds(detector("band", sides="below", gap_s=0.0), values)] == [100]


def test_a_number_without_its_sign() -> None:
    values = [value * (-1) ** index for index, value in enumerate(noise(200))]
    assert [index for index, _ in founds(detector("band", size=True), [*values, -30.0])] == [200]

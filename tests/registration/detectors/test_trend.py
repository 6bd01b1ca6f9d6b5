"""A drift beyond its noise, once."""

from __future__ import annotations

from random import Random

from tests.registration.watching import detector, founds


def test_a_drift_beyond_its_noise_is_one_event() -> None:
    random = Random(0)
    level = [20.0 + random.gauss(0, 0.1) for _ in range(600)]
    rising = [20.0 + 0.02 * step + random.gauss(0, 0.1) for step in range(600)]
    found = founds(detector("trend", window_s=160.0, strength=6.0, least=0.5), [*level, *rising])
    assert len(found) == 1
    assert 600 < found[0][0] < 800
    assert found[0][1].fields["side"] == "rising"
    slope = found[0][1].fields["slope_per_min"]
    assert isinstance(slope, float)
    assert 0.3 < slope < 1.5


def test_noise_has_no_trend() -> None:
    random = Random(1)
    values = [random.gauss(0, 1) for _ in range(5000)]
    assert len(founds(detector("trend", window_s=160.0, strength=6.0), values)) <= 1


def test_a_gap_longer_than_the_window_begins_anew() -> None:
    watcher = detector("trend", window_s=16.0, strength=3.0)
    assert founds(watcher, [0.0] * 40) == []
    assert founds(watcher, [100.0] * 40, start=5000) == []

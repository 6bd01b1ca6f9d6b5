"""Messages of one wording have one template."""

from __future__ import annotations

import pytest

from wakeful.domains.template import template


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("Using default takeoff altitude: 2.5 m", "Using default takeoff altitude: 10.0 m"),
        ("opened ./log/2024-03-18/14_49_10.ulg", "opened ./log/2025-01-02/00_00_01.ulg"),
        ("device 0x1f failed", "device 0x2A failed"),
        ("wheel speed -3.2e is off", "wheel speed 4.1e is off"),
    ],
)
def test_numbers_paths_and_addresses_do_not_make_a_new_wording(one: str, other: str) -> None:
    assert template(one) == template(other)


def test_other_words_are_another_wording() -> None:
    assert template("motor 1 failed") != template("motor 1 stopped")

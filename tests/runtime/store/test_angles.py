"""Angles in data that are more likely degrees are asked about once; added up headings are not."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import arael

TEXT = """
struct Pose {
    key name
    name: string
    param heading: angle
    param tilt: euler = [0, 0, 0]
    compass: real [rad] = 0
    phase: real = 500
    constraint seen { rad_diff(heading, compass) / 0.1 [rad] + 0 * phase }
    constraint level { tilt / 0.1 [rad] }
}
root Track { poses: list of Pose }
"""


def warned(headings: Any, **fields: Any) -> list[str]:
    model = arael.loads(TEXT, interpret=True)()
    names = [f"p{k}" for k in range(len(headings))]
    model.poses.extend(name=names, heading=headings, **fields)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        model.solve()
        model.solve()
    return [str(one.message) for one in found if "W0702" in str(one.message)]


def test_degrees_are_asked_about_once_a_field_with_row_and_key() -> None:
    heading, compass = warned([0.0, 90.0, 180.0, 3.0], compass=[0.0, 0.1, -45.0, 0.0])
    assert "an angle of 90 rad: degrees?" in heading
    assert "poses[1].heading (`name` 'p1')" in heading and "1 more rows" in heading
    assert "give it in radians: 90 degrees are 1.5708" in heading
    assert "an angle of -45 rad: degrees?" in compass
    assert "or declare `compass: real [deg]` and write" in compass


def test_components_of_euler_angles() -> None:
    tilt = np.zeros((2, 3))
    tilt[1, 2] = 30
    (found,) = warned([0.0, 0.0], tilt=tilt)
    assert "an angle of 30 rad: degrees?" in found and "poses[1].tilt" in found


@pytest.mark.parametrize(
    "headings",
    [
        np.cumsum(np.full(40, 0.6)),  # four turns
        -3.1 - np.cumsum(np.full(40, 3.0)),
        [0.0, 3.1, 6.2, 6.4, 4.0, 6.5],
        [6.28, -6.28],
        [0.0, 5000.0],  # no degrees
    ],
    ids=["turns", "backwards", "and back", "full turns", "far"],
)
def test_turns_that_add_up_are_no_degrees(headings: Any) -> None:
    assert warned(headings) == []


def test_a_trajectory_that_begins_in_degrees() -> None:
    (found,) = warned(90 + np.cumsum(np.full(20, 0.5)))
    assert "an angle of 90.5 rad" in found and "19 more rows" in found

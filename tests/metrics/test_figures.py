"""Errors of trajectories equal those of evo: figures that it produced, and evo itself."""

from __future__ import annotations

import contextlib
import io as std_io
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arael import metrics
from arael.diagnostics.records import AraelError
from arael.metrics import Trajectory
from tests.metrics import evo_figures
from tests.metrics.cases import ALIGNMENTS, DELTAS, SEEDS, pair
from tests.optional import needs

FIGURES = json.loads((Path(__file__).parent / "evo_figures.json").read_text())
CLOSE = 1e-9


def associated(seed: int) -> tuple[Trajectory, Trajectory]:
    return metrics.associate(*pair(seed), max_diff=0.01, offset=0.001)


def aligned(reference: Trajectory, estimate: Trajectory, how: str) -> Trajectory:
    if how == "none":
        return estimate
    if how == "origin":
        return metrics.align_origin(estimate, reference)[0]
    options: dict[str, Any] = {
        "scale": how == "similarity",
        "only_scale": how == "scale",
        "first": 10 if how == "first 10" else None,
    }
    return metrics.align(estimate, reference, **options)[0]


def close(found: dict[str, float], expected: dict[str, float]) -> bool:
    return found == pytest.approx(expected, rel=CLOSE, abs=CLOSE)


def test_the_version_of_evo_is_recorded() -> None:
    assert FIGURES["evo"] == "1.38.1" and len(FIGURES["ate"]) == 72 and len(FIGURES["rpe"]) == 75


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("how", ALIGNMENTS)
def test_absolute_errors_are_those_of_evo(seed: int, how: str) -> None:
    reference, estimate = associated(seed)
    moved = aligned(reference, estimate, how)
    for part in ("translation", "rotation", "full", "angle_deg"):
        found = metrics.ate(reference, moved, part).statistics.to_dict()  # type: ignore[arg-type]
        assert close(found, FIGURES["ate"][f"{seed} {how} {part}"]), part


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("delta", "unit"), DELTAS)
def test_relative_errors_are_those_of_evo(seed: int, delta: float, unit: str) -> None:
    reference, estimate = associated(seed)
    for part in ("translation", "rotation", "full", "angle_deg", "distance_ratio"):
        expected = FIGURES["rpe"][f"{seed} {delta:g} {unit} {part}"]
        assert expected is not None
        errors = metrics.rpe(reference, estimate, part, delta=delta, unit=unit)  # type: ignore[arg-type]
        assert close(errors.statistics.to_dict(), expected), part


@pytest.mark.sweep(4)
@needs("evo")
@pytest.mark.parametrize("seed", range(10, 14))
def test_evo_finds_the_same(seed: int) -> None:
    """Random trajectories, also with all pairs and pairs from the reference."""
    reference, estimate = associated(seed)
    theirs, their_estimate = evo_figures.associated(seed)
    assert estimate.times is not None
    assert theirs.timestamps.tolist() == reference.times.tolist()  # type: ignore[union-attr]
    assert their_estimate.timestamps.tolist() == estimate.times.tolist()
    how = ALIGNMENTS[seed % len(ALIGNMENTS)]
    moved, their_moved = (
        aligned(reference, estimate, how),
        evo_figures.aligned(theirs, their_estimate, how),
    )
    for part in evo_figures.PARTS:
        if part != "distance_ratio":
            found = metrics.ate(reference, moved, part)  # type: ignore[arg-type]
            expected = evo_figures.absolute(theirs, their_moved, part)
            assert close(found.statistics.to_dict(), expected)
        for delta, unit in DELTAS:
            for every, source in ((False, "reference"), (True, "estimate")):
                with contextlib.redirect_stdout(std_io.StringIO()):  # evo prints its progress
                    figures = evo_figures.relative(
                        theirs,
                        their_moved,
                        part,
                        delta,
                        unit,
                        all_pairs=every,
                        pairs_from_reference=source == "reference",
                    )
                arguments: dict[str, Any] = {"delta": delta, "unit": unit, "pairs_from": source}
                if figures is None:
                    with pytest.raises(AraelError, match="E0729"):
                        metrics.rpe(reference, moved, part, all_pairs=every, **arguments)  # type: ignore[arg-type]
                    continue
                errors = metrics.rpe(reference, moved, part, all_pairs=every, **arguments)  # type: ignore[arg-type]
                assert close(errors.statistics.to_dict(), figures), (part, delta, unit, every)


# --- what the numbers mean -----------------------------------------------------------------------


def straight(count: int = 5, **more: Any) -> Trajectory:
    positions = np.column_stack([np.arange(count), np.arange(count) % 2, np.zeros(count)])
    times = more.pop("times", np.arange(float(count)))
    return Trajectory(positions, [[1, 0, 0, 0]] * count, times, **more)


def test_a_similarity_is_recovered() -> None:
    reference, _ = pair(5)
    moved = metrics.Alignment(metrics.umeyama(reference.positions, -reference.positions).rotation,
                              np.array([1.0, 2.0, 3.0]), 2.5)  # fmt: skip
    estimate = moved.apply(reference)
    back, found = metrics.align(estimate, reference, scale=True)
    assert found.scale == pytest.approx(1 / 2.5, rel=1e-12)
    assert metrics.ate(reference, back).statistics.max < 1e-11
    assert metrics.ate(reference, back, "angle_deg").statistics.max < 1e-5
    rigid, without = metrics.align(estimate, reference)
    assert without.scale == 1 and metrics.ate(reference, rigid).statistics.rmse > 1


def test_the_first_poses_agree_after_alignment_of_the_origin() -> None:
    reference, estimate = associated(6)
    moved, _ = metrics.align_origin(estimate, reference)
    assert moved.matrices[0] == pytest.approx(reference.matrices[0], abs=1e-12)


def test_a_constant_offset_is_an_absolute_and_no_relative_error() -> None:
    reference = straight()
    estimate = Trajectory(
        np.add(reference.positions, (0, 0, 3)), reference.quaternions, reference.times
    )
    found = metrics.ate(reference, estimate)
    assert found.values.tolist() == [3] * 5 and found.unit == "m"
    assert found.statistics.sse == 45 and found.statistics.std == 0
    relative = metrics.rpe(reference, estimate, delta=2)
    assert relative.values.max() == 0 and relative.rows.tolist() == [[0, 2], [2, 4]]


@pytest.mark.parametrize(
    ("options", "pairs"),
    [
        ({"delta": 2}, [[0, 2], [2, 4]]),
        ({"delta": 2, "all_pairs": True}, [[0, 2], [1, 3], [2, 4]]),
        ({"delta": 2.8, "unit": "m"}, [[0, 2], [2, 4]]),
        ({"delta": 2.8, "unit": "m", "all_pairs": True}, [[0, 2], [1, 3], [2, 4]]),
    ],
)
def test_pairs(options: dict[str, Any], pairs: list[list[int]]) -> None:
    assert metrics.pairs_of(straight(), **options).tolist() == pairs


def test_poses_are_associated_by_time() -> None:
    reference = straight(5)
    estimate = straight(4, times=np.array([0.009, 1.2, 2.995, 4.02]))
    one, other = metrics.associate(reference, estimate)
    assert one.times is not None and one.times.tolist() == [0, 3]
    assert other.times is not None and other.times.tolist() == [0.009, 2.995]
    one, _ = metrics.associate(reference, estimate, max_diff=0.1, offset=-0.2)
    assert one.times is not None and one.times.tolist() == [1]


def standing() -> Trajectory:
    return replace(straight(5), positions=np.ones((5, 3)))


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda a, b: metrics.associate(a, straight(5, times=a.times + 0.5)), "within 0.01 s"),
        (lambda a, b: metrics.associate(a, straight(5, times=None)), "the estimate has no times"),
        (
            lambda a, b: metrics.associate(straight(5, times=None), straight(4, times=None)),
            "the reference has 5 and the estimate 4",
        ),
        (lambda a, b: metrics.ate(a, b), "5 of the reference and 4 of the estimate"),
        (lambda a, b: metrics.ate(a, a, "translaton"), "did you mean `translation`?"),
        (lambda a, b: metrics.ate(a, a, "distance_ratio"), "relative errors only"),
        (lambda a, b: metrics.rpe(a, a, delta=0), "a whole number from 1"),
        (lambda a, b: metrics.rpe(a, a, delta=1.5), "a whole number from 1"),
        (lambda a, b: metrics.rpe(a, a, delta=-1, unit="m"), "a positive number"),
        (lambda a, b: metrics.rpe(a, a, delta=1, unit="km"), "no unit `km`"),
        (lambda a, b: metrics.rpe(a, a, delta=200, unit="deg"), "at most 180 degrees"),
        (lambda a, b: metrics.rpe(a, a, delta=100, unit="m"), "no pair of poses is 100 m apart"),
        (lambda a, b: metrics.rpe(a.rows([0]), a.rows([0])), "no pair of poses"),
        (lambda a, b: metrics.align(a.rows([0, 1]), a.rows([0, 1])), "on a line"),
        (lambda a, b: metrics.align(a, b), "as many points"),
        (lambda a, b: metrics.associate(a, b.rows([])), "the estimate has no poses"),
        (lambda a, b: metrics.associate(a.rows([]), b), "the reference has no poses"),
        (lambda a, b: metrics.rpe(a, a, delta=4, unit="rad"), "at most 180 degrees"),
        (lambda a, b: metrics.rpe(a, a, delta=np.inf), "a whole number from 1"),
        (lambda a, b: metrics.rpe(a, a, delta=np.inf, unit="m"), "a positive number"),
        (lambda a, b: metrics.rpe(a, a, pairs_from="refrence"), "found 'refrence'"),
        (lambda a, b: metrics.rpe(standing(), standing(), "distance_ratio"), "is apart"),
        (lambda a, b: metrics.align(standing(), standing(), only_scale=True), "in one place"),
        (lambda a, b: metrics.align_origin(a.rows([]), b), "without poses"),
    ],
)
def test_what_cannot_be_compared_is_named(act: Any, words: str) -> None:
    with pytest.raises(AraelError, match="E0729") as failure:
        act(straight(5), straight(4))
    assert words in str(failure.value)


@pytest.mark.parametrize("size", [1.0, 100.0, 1e4])
def test_a_line_of_any_length_determines_no_rotation(size: float) -> None:
    """Rounding across the line, in proportion to its length, was taken for a plane."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        points = size * rng.uniform(size=(50, 1)) * rng.normal(size=3)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        with pytest.raises(AraelError, match="on a line"):
            metrics.umeyama(points, points @ turn.T)
        bent = points + 1e-5 * size * rng.normal(size=(50, 3))
        turn *= np.linalg.det(turn)
        np.testing.assert_allclose(metrics.umeyama(bent, bent @ turn.T).rotation, turn, atol=1e-6)


def test_a_line_determines_the_scale() -> None:
    line = straight(5)
    aligned, found = metrics.align(
        replace(line, positions=line.positions / 2), line, only_scale=True
    )
    assert found.scale == pytest.approx(2)
    np.testing.assert_allclose(aligned.positions, line.positions, atol=1e-12)

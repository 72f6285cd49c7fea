"""Residuals by row: raw, whitened, after the loss."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

TEXT = """
struct Sat {
    range: real [m]
    sigma: real [m] = 2
    at: vec2 [m]
    used: bool = true
    constraint pseudorange when used loss huber(1.5) { (norm(root.pos - at) - range) / sigma }
    constraint plane when used { let d = root.pos - at
        [-(0.5 * d), 2 * (d.x - 1) / sigma] }
}
root Gnss {
    param pos: vec2 [m] = [0.1, 0.2]
    sats: list of Sat
    w: vec2 = [2, 3]
    constraint prior { root.w .* (root.pos - [1, 1]) }
}
"""
AT = np.array([[5.0, 0], [0, 6], [3, 4], [1, 1]])
RANGE = np.array([5.0, 6, 30, 2])


@pytest.fixture
def model(tmp_path: Path) -> arael.Model:
    path = tmp_path / "gnss.arael"
    path.write_text(TEXT)
    found = arael.load(path, interpret=True)()
    found.sats.extend(range=RANGE, at=AT, used=[True, True, True, False])
    return found


def test_values_before_and_after_whitening_and_loss(model: arael.Model) -> None:
    found = model.residual_values("Sat.pseudorange")
    assert found.rows == ("sats[0]", "sats[1]", "sats[2]") and len(found) == 3
    raw = np.linalg.norm([0.1, 0.2] - AT[:3], axis=1) - RANGE[:3]
    np.testing.assert_allclose(found.raw[:, 0], raw)
    np.testing.assert_allclose(found.whitened[:, 0], raw / 2)
    square = (raw / 2) ** 2
    huber = np.where(square < 2.25, square, 3 * np.sqrt(square) - 2.25)
    np.testing.assert_allclose(found.cost, huber)
    np.testing.assert_allclose(found.robust[:, 0], np.sign(raw) * np.sqrt(huber))
    np.testing.assert_allclose(found.weight, huber / square)


def test_the_costs_are_those_of_the_cost_table(model: arael.Model) -> None:
    for label, cost in model.cost_table().items():
        assert model.residual_values(label).cost.sum() == pytest.approx(cost)


def test_factors_of_data_are_left_out_and_signs_kept(model: arael.Model) -> None:
    found = model.residual_values("Sat.plane")
    d = np.array([0.1, 0.2]) - AT[:3]
    np.testing.assert_allclose(found.whitened, np.column_stack([-0.5 * d, d[:, 0] - 1]))
    np.testing.assert_allclose(found.raw, np.column_stack([-d, d[:, 0] - 1]))
    prior = model.residual_values("Gnss.prior")
    assert prior.rows == ("Gnss",)
    np.testing.assert_allclose(prior.raw, [[-0.9, -0.8]])
    np.testing.assert_allclose(prior.whitened, [[-1.8, -2.4]])


def test_residuals_added_at_run_time(model: arael.Model) -> None:
    model.residuals.add(
        "2 * (pos.x - b) / s", label="left", data={"b": [1, 2], "s": 0.5}, loss="cauchy(1)"
    )
    found = model.residual_values("left")
    np.testing.assert_allclose(found.raw[:, 0], [-0.9, -1.9])
    np.testing.assert_allclose(found.whitened[:, 0], [-3.6, -7.6])
    np.testing.assert_allclose(found.cost, np.log1p([3.6**2, 7.6**2]))
    assert found.rows == ("row 0", "row 1")


def test_an_unknown_constraint(model: arael.Model) -> None:
    with pytest.raises(AraelError, match="E1037") as caught:
        model.residual_values("Sat.pseudo_range")
    assert "did you mean `Sat.pseudorange`?" in str(caught.value)


def test_of_a_model_of_text() -> None:
    model = arael.loads(TEXT, interpret=True)()
    np.testing.assert_allclose(model.residual_values("Gnss.prior").raw, [[-0.9, -0.8]])


@pytest.mark.parametrize("change", ["other", "gone"])
def test_the_text_that_was_loaded_counts(model: arael.Model, tmp_path: Path, change: str) -> None:
    before = model.residual_values("Sat.pseudorange")
    path = tmp_path / "gnss.arael"
    if change == "gone":
        path.unlink()
    else:
        path.write_text(path.read_text().replace("- range", "- 2 * range"))
    np.testing.assert_array_equal(model.residual_values("Sat.pseudorange").raw, before.raw)


@pytest.mark.parametrize("change", ["other", "gone"])
def test_an_imported_file_that_was_changed(tmp_path: Path, change: str) -> None:
    struct, root = (TEXT[: TEXT.index("root Gnss")], TEXT[TEXT.index("root Gnss") :])
    imported, path = tmp_path / "sat.arael", tmp_path / "gnss.arael"
    imported.write_text(struct)
    path.write_text(f'import "sat.arael"\n{root}')
    asked, late = (arael.load(path, interpret=True)() for _ in range(2))
    for model in (asked, late):
        model.sats.extend(range=RANGE, at=AT)
    before = asked.residual_values("Sat.pseudorange")
    assert before.raw.shape == (4, 1)
    if change == "gone":
        imported.unlink()
    else:
        changed = struct.replace("- range", "- 2 * range").replace("d.x - 1", "d.x - 2")
        imported.write_text(changed)
    again = asked.residual_values("Sat.pseudorange")  # was derived before
    np.testing.assert_array_equal(again.raw, before.raw)
    plane = asked.residual_values("Sat.plane")  # of the text that was read then
    np.testing.assert_array_equal(plane.whitened, plane.robust)
    with pytest.raises(AraelError, match=r"E1037.*is not what was compiled"):
        late.residual_values("Sat.plane")


def test_the_text_is_derived_once(model: arael.Model, monkeypatch: pytest.MonkeyPatch) -> None:
    first = model.residual_values("Sat.pseudorange")
    monkeypatch.setattr("arael.residuals.unweighted.compile_constraint", None)
    model.pos = [1.0, 2.0]
    again = model.residual_values("Sat.pseudorange")
    expected = np.linalg.norm([1.0, 2.0] - AT, axis=1) - RANGE
    assert np.allclose(again.raw[:, 0], expected[:3])
    assert not np.allclose(first.raw, again.raw)

"""What the whole diagnosis finds, on problems broken in one way each."""

from __future__ import annotations

import json

import numpy as np
import pytest

import arael
from arael.cli.main import run
from tests.analysis.maps import PLANAR, planar


@pytest.fixture
def model(tmp_path):
    found = planar(tmp_path)
    found.solve(rel_precision=1e-12, abs_precision=1e-12)
    return found


def topics(model) -> list[str]:
    return [finding.topic for finding in model.diagnose().findings]


def test_nothing_is_wrong_with_a_good_solution(model) -> None:
    found = model.diagnose()
    assert found.findings == ()
    assert str(found).endswith("nothing suspicious was found")
    assert found.cost == pytest.approx(model.cost())
    assert found.decrement == pytest.approx(0, abs=1e-8)
    low, high = found.eigenvalues
    hessian = model.hessian()
    scale = 1 / np.sqrt(np.diag(hessian))
    values = np.linalg.eigvalsh(hessian * scale[:, None] * scale[None, :])
    assert (low, high) == pytest.approx((values[0], values[-1]), rel=1e-8)


def test_start_is_no_minimum(model) -> None:
    model.poses[3].t.value = [0.0, 0.0]
    found = model.diagnose()
    assert "not-minimal" in topics(model)
    j = model.jacobian()
    step = np.linalg.lstsq(j.dense(), -j.residuals, rcond=None)[0]
    promised = j.residuals @ j.residuals - np.sum((j.residuals + j.dense() @ step) ** 2)
    assert found.decrement == pytest.approx(promised, rel=1e-8)
    gradient = model.gradient()
    at = int(np.argmax(np.abs(gradient)))
    assert found.gradient == (model.parameter_names()[at], pytest.approx(abs(gradient[at])))


BOUNDED = """
struct Point { x: real; y: real; constraint fit { root.slope * x + root.offset - y } }
root Line {
    param slope: real in 0 .. 1
    param offset: real
    points: list of Point
}
"""


@pytest.mark.parametrize("precision", ["f64", "f32"])
def test_a_solution_on_a_bound_is_a_minimum(tmp_path, precision) -> None:
    """The gradient across the bound does not vanish there, and no step follows it."""
    path = tmp_path / "bounded.arael"
    path.write_text(BOUNDED, encoding="utf-8")
    model = arael.load(path, interpret=True, precision=precision)(slope=0.5, offset=0)
    model.points.extend(x=[0.0, 1, 2, 3], y=[0.0, 2, 4, 6])
    assert topics(model) == ["not-minimal"]
    assert model.solve().converged and model.slope.value == 1
    found = model.diagnose()
    assert "not-minimal" not in [one.topic for one in found.findings]
    assert found.decrement == pytest.approx(0, abs=1e-6)
    assert found.gradient[0] == "offset"
    assert not any("not a minimum" in text for text in model.report().findings)
    # On the bound, but the other parameter is off: the decrease is that of moving it alone.
    model.offset = 2.0
    found = model.diagnose()
    assert [one.topic for one in found.findings] == ["not-minimal"]
    assert found.decrement == pytest.approx(4 * 0.5**2, rel=1e-5)
    # A bound from which the cost leads inwards holds nothing.
    model.slope = 0
    assert model.diagnose().gradient[0] == "slope"


def test_outlier_is_named(model) -> None:
    model.edges[4].isigma = 1000.0
    finding = next(f for f in model.diagnose().findings if f.topic == "outlier")
    assert finding.message.startswith("`Edge.between[4] at edges[4]` alone is ")


def test_dominant_constraint_is_named(model) -> None:
    for fix in model.fixes:
        fix.isigma = 4000.0
    finding = next(f for f in model.diagnose().findings if f.topic == "dominant")
    assert finding.message.startswith("`Fix.fix` is 100 % of the cost")


def test_inactive_and_free(tmp_path) -> None:
    model = planar(tmp_path, fixes=0)
    assert topics(model)[0] == "free"
    assert "inactive" in topics(model)
    assert "together along x" in model.diagnose().findings[0].message


def test_untouched(model) -> None:
    model.poses.append(t=[0, 0], th=0.0)
    finding = model.diagnose().findings[0]
    assert finding.topic == "untouched"
    assert finding.message == "no residual changes with `poses[8].t.x`, `poses[8].t.y`, " \
        "`poses[8].th`"  # fmt: skip
    assert "free" not in topics(model)


def test_not_finite_comes_first_and_alone(model) -> None:
    model._store.tables["edges"].column("t")[2, 0] = np.inf
    found = model.diagnose()
    assert found.findings[0].topic == "non-finite"
    assert "`edges[2].t[0]` is inf" in found.findings[0].message
    assert found.free is None
    assert str(found)


def test_stiff(model) -> None:
    for fix in model.fixes:
        fix.isigma = 1e-4
    assert "stiff" in topics(model)


def test_as_plain_data(model) -> None:
    found = json.loads(json.dumps(model.diagnose().to_dict()))
    assert found["rank"] == found["parameters"] == 24
    assert found["costs"].keys() == {"Edge.between", "Fix.fix"}


def test_command(capsys: pytest.CaptureFixture[str], tmp_path) -> None:
    model = planar(tmp_path, fixes=0)
    model.write(tmp_path / "map.json")
    (tmp_path / "map.arael").write_text(PLANAR)
    args = ["diagnose", str(tmp_path / "map.arael"), str(tmp_path / "map.json")]
    assert run(args) == 1
    out = capsys.readouterr().out
    assert "found: 3 of 24 directions are free: `poses.t` move together along x" in out
    assert run([*args, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [f["topic"] for f in found["findings"]] == ["free", "inactive"]

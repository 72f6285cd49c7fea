"""`marginalize` in a model names what the Schur complement eliminates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael

MODEL = """
struct Camera {{ param pos: vec2 }}
struct Point {{ param pos: vec2 }}
struct Sight {{
    camera: ref Camera in root.cameras
    point:  ref Point in root.points
    d:      vec2
    constraint sight {{ point.pos - camera.pos - d }}
}}
struct Held {{
    camera: ref Camera in root.cameras
    constraint held {{ camera.pos * 3 }}
}}
root Map {{
    cameras: list of Camera
    points:  list of Point
    sights:  list of Sight
    held:    list of Held
    {marginalize}
}}
"""


def solved(folder: Path, marginalize: str, **options: object) -> tuple[object, np.ndarray]:
    path = folder / "map.arael"
    path.write_text(MODEL.format(marginalize=marginalize))
    rng = np.random.default_rng(0)
    model = arael.load(path)()
    model.cameras.extend(pos=rng.standard_normal((12, 2)))
    model.points.extend(pos=rng.standard_normal((9, 2)))
    camera, point = (index.ravel() for index in np.mgrid[:12, :9])
    model.sights.extend(camera=camera, point=point, d=rng.standard_normal((108, 2)))
    model.held.append(camera=0)
    result = model.solve(**options)  # type: ignore[arg-type]
    return result, np.vstack([model.cameras.pos.value, model.points.pos.value])


@pytest.mark.parametrize(("named", "count"), [("points", 9), ("cameras", 12)])
def test_named_collections_are_eliminated(tmp_path: Path, named: str, count: int) -> None:
    _, expected = solved(tmp_path, "", solver="dense")
    result, found = solved(tmp_path, f"marginalize {named}", solver="schur")
    assert result.plan["solver"] == "schur"  # type: ignore[attr-defined]
    assert result.plan["eliminated"] == count  # type: ignore[attr-defined]
    assert found == pytest.approx(expected, abs=1e-8)


def test_an_option_goes_over_the_model(tmp_path: Path) -> None:
    options = {"solver": "schur", "solver_options": {"eliminate": "cameras"}}
    result, _ = solved(tmp_path, "marginalize points", **options)
    assert result.plan["eliminated"] == 12  # type: ignore[attr-defined]


def test_a_small_system_is_dense_whatever_could_be_eliminated(tmp_path: Path) -> None:
    result, found = solved(tmp_path, "marginalize points")
    assert result.plan["solver"] == "dense"  # type: ignore[attr-defined]
    assert "up to 64 unknowns" in result.plan["why"]  # type: ignore[attr-defined]
    _, expected = solved(tmp_path, "marginalize points", solver="schur")
    assert found == pytest.approx(expected, abs=1e-8)

"""What is sent to the viewer Rerun: places, ellipsoids, links, residuals and costs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError
from tests.optional import needs, require

CHAIN = """
struct Pose { param t: vec2 [m] = [0, 0] }
struct Step { a: ref Pose in root.poses; b: ref Pose in root.poses
    constraint step { (b.t - a.t - [1, 0]) / 0.1 [m] } }
root Chain { poses: list of Pose; steps: list of Step
    start: ref Pose in root.poses
    constraint held { start.t / 0.2 [m] } }
"""


def chain() -> Any:
    model = arael.loads(CHAIN, interpret=True)()
    model.poses.extend(3)
    model.steps.extend(a=[0, 1], b=[1, 2])
    model.start = 0
    return model


@needs("rerun")
def test_a_model_and_a_result_are_logged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rr = require("rerun")
    logged: dict[str, Any] = {}
    log = rr.RecordingStream.log

    def spy(self: Any, path: str, what: Any, **options: Any) -> None:
        logged[path] = what
        log(self, path, what, **options)

    monkeypatch.setattr(rr.RecordingStream, "log", spy)
    model = chain()
    result = model.solve()
    arael.plot.rerun(model, result, save=tmp_path / "chain.rrd")
    assert (tmp_path / "chain.rrd").stat().st_size > 1000
    places = np.array(logged["map/poses"].positions.as_arrow_array().to_pylist())
    np.testing.assert_allclose(places, [[0, 0, 0], [1, 0, 0], [2, 0, 0]], atol=1e-6)
    sizes = np.array(logged["map/poses/uncertainty"].half_sizes.as_arrow_array().to_pylist())
    variances = 0.2**2 + 0.1**2 * np.arange(3)
    np.testing.assert_allclose(sizes.max(axis=1), 2 * np.sqrt(variances), rtol=1e-5)
    strips = logged["map/links/poses"].strips.as_arrow_array().to_pylist()
    ends = [[round(point[0], 6) for point in strip] for strip in strips]
    assert ends == [[0, 1], [1, 2]]
    assert "solve/cost" in logged


@needs("rerun")
def test_anything_else_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AraelError, match="E0828"):
        arael.plot.rerun(3, save=tmp_path / "x.rrd")  # type: ignore[arg-type]


def test_a_missing_viewer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.plot.viewer.find_spec", lambda name: None)
    with pytest.raises(AraelError, match=r"(?s)E0860.*arael\[rerun\]"):
        arael.plot.rerun(chain())


@needs("rerun")
def test_a_solve_is_streamed_after_each_accepted_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rr = require("rerun")
    shown: list[Any] = []
    log, time = rr.RecordingStream.log, rr.RecordingStream.set_time
    steps: list[int] = []

    def spy(self: Any, path: str, what: Any, **options: Any) -> None:
        if path == "map/poses":
            places = np.array(what.positions.as_arrow_array().to_pylist())
            shown.append((steps[-1], options["static"], places))
        log(self, path, what, **options)

    def spy_time(self: Any, timeline: str, **options: Any) -> None:
        if timeline == "step":
            steps.append(options["sequence"])
        time(self, timeline, **options)

    monkeypatch.setattr(rr.RecordingStream, "log", spy)
    monkeypatch.setattr(rr.RecordingStream, "set_time", spy_time)
    model = chain()
    model.poses.t.value[:] = 5.0
    seen: list[float] = []
    result = arael.plot.rerun_solve(
        model, save=tmp_path / "live.rrd", on_step=lambda now, _: seen.append(now.cost())
    )
    count = result.accepted_iterations
    assert [step for step, _, _ in shown] == [*range(count + 1), count]
    assert not any(static for _, static, _ in shown)
    np.testing.assert_allclose(shown[0][2][:, :2], 5.0)
    assert len(seen) == count >= 1
    np.testing.assert_allclose(shown[-2][2], shown[-1][2], atol=1e-6)
    np.testing.assert_allclose(shown[-1][2], [[0, 0, 0], [1, 0, 0], [2, 0, 0]], atol=1e-6)


@needs("rerun")
def test_a_map_is_shown_again_in_the_same_stream(tmp_path: Path) -> None:
    model = chain()
    stream = arael.plot.rerun(model, save=tmp_path / "map.rrd", step=0)
    assert arael.plot.rerun(model, stream=stream, step=1) is stream
    with pytest.raises(AraelError, match="E0828"):
        arael.plot.rerun(model, stream="map.rrd")

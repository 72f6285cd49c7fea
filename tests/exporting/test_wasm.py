"""A solver as a WebAssembly module, run in Node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.exporting import export, wasm
from tests.exporting.test_solver import calibration, graph
from tests.optional import PROGRAMS, program

RUN = """
import { readFile } from "node:fs/promises";
import { load } from "./calibration.mjs";
const problem = await load(readFile(new URL("./calibration.wasm", import.meta.url)));
const said = problem.solve({ strategy: STRATEGY });
problem.readings_count = 0;
problem.sensors_count = 0;
const empty = problem.solve();
problem.readings_count = 99;
const full = problem.solve();
let refused = "";
try { problem.solve({ max: 3 }); } catch (error) { refused = error.message; }
console.log(JSON.stringify({
  refused,
  said, empty, full, sensor: [...problem.sensor], covariance: problem.covariance_sensor(77),
}));
"""


def needs_clang() -> None:
    if not any(map(shutil.which, wasm.CLANG)):
        pytest.skip(f"needs clang: {PROGRAMS['clang']}")


@pytest.mark.parametrize("strategy", ["dogleg", "damping"])
def test_a_module_in_node_solves_as_arael(strategy: str, tmp_path: Path) -> None:
    needs_clang()
    node = program("node")
    path, model = calibration(tmp_path)
    project = export(path, "wasm", data=model)
    project.write(tmp_path)
    (tmp_path / "run.mjs").write_text(RUN.replace("STRATEGY", json.dumps(strategy)))
    printed = subprocess.run(
        [node, "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True
    ).stdout
    found = json.loads(printed)
    wanted = model.solve()
    assert found["said"]["status"] == "converged"
    np.testing.assert_allclose(found["said"]["cost"], wanted.cost, rtol=1e-7)
    solved = np.column_stack([model.sensors.offset.value, model.sensors.gain.value])
    np.testing.assert_allclose(np.reshape(found["sensor"], (3, 2)), solved, atol=1e-4)
    assert found["empty"]["status"] == "converged"
    assert found["full"]["status"] == "bad_count"
    assert found["refused"].startswith("solve has no option max")
    assert found["covariance"] is None
    declared = project.files["calibration.d.mts"]
    assert isinstance(declared, str)
    assert "readonly sensor: Float64Array;" in declared
    assert "readings_count: number;" in declared


def test_a_compiler_without_webassembly_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, model = graph(4, tmp_path)
    monkeypatch.setattr(wasm, "CLANG", ("no-such-compiler",))
    with pytest.raises(AraelError, match="no clang was found"):
        export(path, "wasm", data=model)
    monkeypatch.setattr(wasm, "CLANG", ("false",))
    with pytest.raises(AraelError, match="clang cannot compile or link WebAssembly"):
        export(path, "wasm", data=model)


def test_a_module_needs_a_size() -> None:
    with pytest.raises(AraelError, match="a solver of fixed size, and there is none"):
        export("pose_graph_2d", "wasm")

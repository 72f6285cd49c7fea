"""The generated files of `examples/export_demo`: up to date, strict C99, clean under sanitizers."""

from __future__ import annotations

import runpy
import subprocess
from pathlib import Path

import numpy as np
import pytest

from tests.exporting.built import STRICT, compiler

DEMO = Path(__file__).parents[2] / "examples" / "export_demo"


@pytest.fixture(scope="module")
def demo() -> dict[str, object]:
    return runpy.run_path(str(DEMO / "export_demo.py"))


def test_generated_files_are_those_of_the_script(demo: dict[str, object], update: bool) -> None:
    for name, text in demo["exports"]().items():  # type: ignore[operator]
        if update:
            (DEMO / name).write_text(text, encoding="utf-8")
        assert (DEMO / name).read_text(encoding="utf-8") == text, f"{name}: pytest --update"


def test_the_program_is_clean_and_finds_the_solution(
    demo: dict[str, object], tmp_path: Path
) -> None:
    sources = [DEMO / name for name in ("window.c", "window_solver.c", "main.c")]
    sanitized = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1"]
    target = tmp_path / "main"
    subprocess.run([compiler(), *STRICT, *sanitized, *sources, "-o", target, "-lm"], check=True)
    printed = subprocess.run([target], capture_output=True, text=True, check=True).stdout
    window = demo["window"]()  # type: ignore[operator]
    result = window.solve(rel_precision=1e-12)
    np.testing.assert_allclose(float(printed.split("-> ")[1].split(",")[0]), result.cost, rtol=1e-6)
    rows = [line.split()[2:] for line in printed.splitlines() if line.startswith("landmark")]
    np.testing.assert_allclose(np.array(rows, float), window.landmarks.pos.value, atol=1e-6)

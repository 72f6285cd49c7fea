"""Each example has its model, its script, and a README with a picture."""

from __future__ import annotations

import re

import pytest

from tests.examples.scripts import EXAMPLES
from tests.examples.test_copies import OWN

FOLDERS = sorted(path for path in EXAMPLES.iterdir() if path.is_dir())
WITH_PICTURE = (
    "bench_band", "bench_investigate", "bench_sparse", "jacobian_demo",
    "linear_demo", "loc_demo", "loc_global_demo", "slam_demo", "user_function_demo",
    "range_slam", "gnss", "spline_trajectory", "landmark_slam_2d", "imu_preintegration",
    "arm_on_curve",
    "online_slam",
)  # fmt: skip


@pytest.mark.parametrize("name", WITH_PICTURE)
def test_model_script_readme_picture(name: str) -> None:
    folder = EXAMPLES / name
    assert list(folder.glob("*.arael"))
    assert (folder / f"{name}.py").is_file()
    text = (folder / "README.md").read_text(encoding="utf-8")
    assert f"({name}.png)" in text
    for target in re.findall(r"\]\(([^)#:]+)\)", text):
        assert (folder / target).exists(), target
    assert (folder / f"{name}.png").stat().st_size < 200_000


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda f: f.name)
def test_copies_of_standard_models_are_up_to_date(folder) -> None:
    standard = EXAMPLES.parent / "models"
    for model in folder.glob("*.arael"):
        own = model.relative_to(EXAMPLES).as_posix() in OWN
        if (standard / model.name).is_file() and not own:
            expected = (standard / model.name).read_text(encoding="utf-8")
            assert model.read_text(encoding="utf-8") == expected


def test_all_are_listed() -> None:
    text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    for name in WITH_PICTURE:
        assert f"`{name}`" in text

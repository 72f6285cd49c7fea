"""`arael diagnose --verdict` and `--next`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import arael
from tests.cli.conftest import Arael
from tests.optional import needs

MODEL = """
struct Shot {
    distance: real
    reading: real
    constraint scale { (root.gain * distance + root.offset - reading) / 0.01 }
}
root Ranger { param gain: real = 1; param offset: real = 0; shots: list of Shot }
"""
PICTURES = """
struct Corner {
    on: vec2
    pixel: vec2 [px]
    isigma: real [1/px] = 5
    constraint lens { (root.f * on + root.c - pixel) * isigma }
}
root Lens { param f: real [px] = 400; param c: vec2 [px] = [300, 200]; corners: list of Corner }
"""


@pytest.fixture
def ranger(tmp_path: Path) -> tuple[Path, Path]:
    """Model and data whose readings are all at one distance."""
    return _written(tmp_path, np.full(20, 2.0))


def _written(folder: Path, distance: object) -> tuple[Path, Path]:
    rng = np.random.default_rng(0)
    d = np.asarray(distance, dtype=float)
    shots = [
        {"distance": x, "reading": y}
        for x, y in zip(d, 1.02 * d - 0.05 + rng.normal(0, 0.01, len(d)), strict=True)
    ]
    (folder / "ranger.arael").write_text(MODEL)
    (folder / "data.json").write_text(json.dumps({"shots": shots}))
    return folder / "ranger.arael", folder / "data.json"


def test_the_verdict_names_what_is_missing(arael: Arael, ranger: tuple[Path, Path]) -> None:
    found = arael("diagnose", *ranger, "--verdict")
    assert found.code == 1
    assert found.out.startswith("converged: cost")
    assert "`gain` and `offset` cannot be told apart" in found.out
    assert "other values of `shots.distance` (now 2 in all rows)" in found.out


def test_a_good_calibration_has_exit_code_0(arael: Arael, tmp_path: Path) -> None:
    files = _written(tmp_path, np.linspace(1, 5, 20))
    found = arael("diagnose", *files, "--verdict", "--json")
    assert found.code == 0
    assert found.json["good"] is True
    assert found.json["result"]["status"] == "converged"
    assert [one["name"] for one in found.json["determined"]] == ["gain", "offset"]


def test_a_parameter_without_effect_is_no_error(arael: Arael, tmp_path: Path) -> None:
    files = _written(tmp_path, np.zeros(20))
    found = arael("diagnose", *files, "--verdict", "--json")
    assert found.code == 1
    (direction,) = found.json["directions"]
    assert direction["words"] == "`gain` is not determined"
    assert direction["missing"][0]["column"] == "shots.distance"
    assert direction["sigma"] is None


@pytest.mark.parametrize("ending", ["md", "txt"])
def test_the_report_is_text(
    arael: Arael, ranger: tuple[Path, Path], tmp_path: Path, ending: str
) -> None:
    path = tmp_path / f"verdict.{ending}"
    assert arael("diagnose", *ranger, "--verdict", "--report", path).code == 1
    text = path.read_text()
    assert "cannot be told apart" in text
    assert text.startswith("# verdict on" if ending == "md" else "verdict on")


def test_the_report_is_a_page(arael: Arael, ranger: tuple[Path, Path], tmp_path: Path) -> None:
    path = tmp_path / "verdict.html"
    arael("diagnose", *ranger, "--verdict", "--report", path)
    text = path.read_text()
    assert "<td>gain</td>" in text
    assert "cannot be told apart" in text
    assert "<svg" not in text


@needs("matplotlib")
def test_the_page_of_a_camera_has_its_picture(arael: Arael, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    on = rng.uniform(-0.5, 0.5, (30, 2))
    pixel = 410 * on + [310, 205] + rng.normal(0, 0.2, on.shape)
    corners = [{"on": a, "pixel": b} for a, b in zip(on.tolist(), pixel.tolist(), strict=True)]
    (tmp_path / "lens.arael").write_text(PICTURES)
    (tmp_path / "data.json").write_text(json.dumps({"corners": corners}))
    path = tmp_path / "verdict.html"
    files = (tmp_path / "lens.arael", tmp_path / "data.json")
    drawn = tmp_path / "lens.png"
    options = ("--verdict", "--report", path, "--plot", drawn, "--image", "640", "400")
    found = arael("diagnose", *files, *options)
    assert found.code == 0
    assert "lens.png" in found.err
    assert "<svg" in path.read_text()
    assert drawn.read_bytes().startswith(b"\x89PNG")


@needs("matplotlib")
def test_a_model_without_pixels_has_no_picture(arael: Arael, ranger: tuple[Path, Path]) -> None:
    found = arael("diagnose", *ranger, "--verdict", "--plot", "lens.png")
    assert found.code == 2
    assert "E0791" in found.err


def test_the_next_measurements_are_chosen(
    arael: Arael, ranger: tuple[Path, Path], tmp_path: Path
) -> None:
    # The measured reading is left out.
    (tmp_path / "shots.csv").write_text("distance\n2\n2.1\n9\n4\n")
    found = arael("diagnose", *ranger, "--next", "2", tmp_path / "shots.csv", "--json")
    assert found.code == 0
    assert found.json["rows"][0] == 2
    assert found.json["sigma"][0] is None  # gain and offset are not determined
    named = f"shots={tmp_path / 'shots.csv'}"
    text = arael("diagnose", *ranger, "--next", "1", named, "--of", "gain", "--criterion", "a")
    assert "A-optimal" in text.out


def test_wrong_options_are_refused(arael: Arael, ranger: tuple[Path, Path], tmp_path: Path) -> None:
    (tmp_path / "shots.csv").write_text("distance\n2\n")
    candidates = ("--next", "1", tmp_path / "shots.csv")
    for options, words in [
        (("--report", "v.html"), "add --verdict"),
        (("--verdict", "--report", "v.pdf"), ".html, .md or .txt"),
        (("--verdict", *candidates), "--verdict or --next"),
        (("--of", "gain"), "--of is for --next"),
        ((*candidates, "--of", "gian"), "nothing named `gian`"),
        (("--next", "1", ranger[1]), "takes a CSV file"),
        (("--next", "1", tmp_path / "none.csv"), "none.csv"),
    ]:
        found = arael("diagnose", *ranger, *options)
        assert found.code == 2, options
        assert words in found.err, found.err


def test_pages_share_one_head() -> None:
    folder = Path(arael.__file__).parent / "cli"
    pages = {path.name: path.read_text(encoding="utf-8") for path in folder.glob("*.html")}
    assert [name for name, text in pages.items() if "<style>" in text] == ["page.html"]
    assert all('extends "page.html"' in pages[name] for name in ("report.html", "verdict.html"))

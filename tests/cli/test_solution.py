"""`arael solve` shows what was solved for, and writes it or refuses to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.cli.conftest import Arael
from tests.optional import needs

GRAPH = """
struct Pose {
    param pos: vec2 [m]
    param heading: angle
    name: int
    constraint near { [pos - [1, 2], heading - 0.5] * root.weight }
}
root Graph {
    param gain: real [m] in 0 .. 1
    param offset: vec2 [m]
    param turn: euler
    param T: transform [m]
    param spare: real
    weight: real = 2
    poses: list of Pose
    other: list of Pose
    constraint anchor { [offset - [3, 4], gain - 5, spare] }
    constraint turned { turn - [0.1, 0.2, 0.3] }
    constraint placed { [T * [1, 0, 0] - [1, 0, 0], T * [0, 1, 0] - [0, 1, 0]] }
    constraint third { T * [0, 0, 1] - [0, 0, 1] }
}
"""


@pytest.fixture
def graph(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    pose = {"pos": [0, 0], "heading": 0, "name": 7}
    data: dict[str, Any] = {
        "gain": 0.5,
        "offset": [0, 0],
        "turn": [0, 0, 0],
        "T": [0, 0, 0, 0, 0, 0],
        "spare": {"value": 3, "fixed": True},
        "poses": [pose] * 7,
        "other": [pose],
    }
    (tmp_path / "graph.arael").write_text(GRAPH)
    (tmp_path / "graph.json").write_text(json.dumps(data))
    monkeypatch.chdir(tmp_path)
    return tmp_path


SOLVE = ("solve", "graph.arael", "graph.json", "--interpret")


def test_root_parameters_with_standard_deviations(arael: Arael, line: Path) -> None:
    design = np.array([[0, 1], [1, 1], [2, 1.0]])
    sigma = np.sqrt(np.linalg.inv(design.T @ design).diagonal())
    found = arael("solve", "line.arael", "line.json", "--json").json
    assert found["parameters"]["a"]["value"] == pytest.approx(2)
    assert [p["sigma"] for p in found["parameters"].values()] == pytest.approx(sigma)
    text = arael("solve", "line.arael", "line.json", "--report", "r.html").out.splitlines()
    assert "a = 2.00 +- 0.71" in text and "b = 1.00 +- 0.91" in text
    page = (line / "r.html").read_text()
    assert "<td>a</td><td>2.00</td><td>0.71</td>" in page


def test_every_kind_of_parameter(arael: Arael, graph: Path) -> None:
    found = arael(*SOLVE, "--json").json["parameters"]
    assert found["gain"] == {"value": 1, "sigma": None, "unit": "m", "note": "on its upper bound 1"}
    assert found["spare"] == {"value": 3, "sigma": None, "unit": "", "note": "fixed"}
    assert found["offset.y"]["value"] == pytest.approx(4)
    assert found["offset.y"]["sigma"] == pytest.approx(1) and found["offset.y"]["unit"] == "m"
    assert found["turn.z"]["value"] == pytest.approx(0.3) and found["turn.z"]["unit"] == "rad"
    assert found["T.rotation.w"]["value"] == pytest.approx(1)
    assert found["T.rotation.w"]["sigma"] is None
    steps = {name: one for name, one in found.items() if name.startswith("step of T.")}
    assert [one["unit"] for one in steps.values()] == ["m"] * 3 + ["rad"] * 3
    assert all(one["value"] is None and one["sigma"] > 0 for one in steps.values())
    text = arael(*SOLVE).out
    assert "(on its upper bound 1)" in text and "spare" in text and "(fixed)" in text


def test_a_singular_system_is_no_failure(arael: Arael, line: Path) -> None:
    text = (line / "line.arael").read_text()
    text = text.replace("a * p.x + b", "a * p.x + b + c - c2").replace(
        "param b: real", "param b: real\n    param c: real\n    param c2: real"
    )
    (line / "line.arael").write_text(text)
    (line / "line.json").write_text(
        '{"a": 0, "b": 0, "c": 0, "c2": 0, "points": [{"x": 0, "y": 1}, {"x": 1, "y": 3}]}'
    )
    command = ("solve", "line.arael", "line.json", "--interpret")
    done = arael(*command)
    assert done.code == 0
    assert "note: the system is singular: 2 of 4 directions are free" in done.out
    assert "(not determined)" in done.out
    found = arael(*command, "--json").json
    assert found["parameters"]["a"]["sigma"] == pytest.approx(np.sqrt(2))
    assert found["parameters"]["c"]["sigma"] is None
    assert any("free direction" in note for note in found["notes"])


@pytest.mark.parametrize(
    ("asked", "rows"),
    [
        ("poses", [0, 1, 2, 3, 4]),
        ("poses[3]", [3]),
        ("poses[-1]", [6]),
        ("poses[:2]", [0, 1]),
        ("poses[5:]", [5, 6]),
        ("poses[2:4]", [2, 3]),
        ("poses[9:]", []),
    ],
)
def test_rows_on_request(arael: Arael, graph: Path, asked: str, rows: list[int]) -> None:
    found = arael(*SOLVE, "--json", "--show", asked).json["rows"][asked]
    assert [row["row"] for row in found] == [f"poses[{row}]" for row in rows]
    for row in found:
        assert list(row) == ["row", "pos.x", "pos.y", "heading"]
        assert row["pos.y"] == pytest.approx(2)


def test_rows_as_text_and_in_the_report(arael: Arael, graph: Path) -> None:
    done = arael(*SOLVE, "--show", "poses[:2]", "--show", "other", "--report", "r.html")
    lines = done.out.splitlines()
    assert "          pos.x  pos.y  heading" in lines
    assert "poses[1]      1      2      0.5" in lines
    assert "(2 of 7 rows)" in lines
    page = (graph / "r.html").read_text()
    assert "<td>other[0]</td><td>1</td><td>2</td><td>0.5</td>" in page


@needs("matplotlib")
def test_the_report_has_parameters_by_collection_the_fit_and_residuals(
    arael: Arael, graph: Path
) -> None:
    arael(*SOLVE, "--report", "r.html")
    page = (graph / "r.html").read_text()
    assert "<details><summary><b>poses</b>: " in page
    assert "<li><b>poses[*].pos.y</b>: 7 values; 2 to 2; standard error " in page
    assert "<td>chi-square</td>" in page and "<h2>Residuals</h2>\n<svg" in page
    assert "<h2>Map</h2>\n<svg" in page and "<script" not in page


@pytest.mark.parametrize(
    ("asked", "text"),
    [
        ("pose", "did you mean `poses`?"),
        ("gain", "there is no collection `gain`"),
        ("poses[a]", "expected NAME or NAME[FROM:TO]"),
    ],
)
def test_no_such_rows(arael: Arael, graph: Path, asked: str, text: str) -> None:
    done = arael(*SOLVE, "--show", asked)
    assert done.code == 2 and "E0857" in done.err and text in done.err
    assert done.out == ""


def test_csv_of_a_collection_named_by_the_file(arael: Arael, graph: Path) -> None:
    done = arael(*SOLVE, "-o", "poses.csv")
    assert done.code == 0
    assert "note: poses.csv does not hold `gain`, `offset`, `turn`, `T`, `spare` and 2 more" in (
        done.err
    )
    head, first, *_ = (graph / "poses.csv").read_text().splitlines()
    values = dict(zip(head.split(","), first.split(","), strict=True))
    assert float(values["pos.x"]) == pytest.approx(1)
    assert float(values["heading"]) == pytest.approx(0.5)


def test_csv_that_would_lose_the_solution_is_refused(arael: Arael, line: Path) -> None:
    for name in ("points.csv", "out.csv", "out.tsv"):
        done = arael("solve", "line.arael", "line.json", "-o", name)
        assert done.code == 2 and done.out == ""
        assert "E0856" in done.err
        assert "would not hold `a`, `b`, and nothing in `points` is solved for" in done.err
        assert "write .json or .npz" in done.err
        assert not (line / name).exists()


def test_csv_of_the_only_collection_needs_its_name_where_more_is_solved(
    arael: Arael, line: Path
) -> None:
    (line / "line.arael").write_text(
        "struct P { param x: real; constraint c { x - root.m } }\n"
        "root R { param m: real; ps: list of P; constraint p { m - 1 } }\n"
    )
    (line / "line.json").write_text('{"m": 0, "ps": [{"x": 3}]}')
    refused = arael("solve", "line.arael", "line.json", "--interpret", "-o", "out.csv")
    assert refused.code == 2
    assert "it would not hold `m`, which are solved for" in refused.err
    assert "or name the file ps.csv" in refused.err
    assert arael("solve", "line.arael", "line.json", "--interpret", "-o", "ps.csv").code == 0
    alone = (line / "line.arael").read_text().replace("param m: real", "m: real = 1")
    (line / "line.arael").write_text(alone.replace("; constraint p { m - 1 }", ""))
    (line / "line.json").write_text('{"ps": [{"x": 3}]}')
    done = arael("solve", "line.arael", "line.json", "--interpret", "-o", "out.csv")
    assert done.code == 0 and done.err == ""


def test_a_summary(arael: Arael, tmp_path: Path) -> None:
    (tmp_path / "line.arael").write_text(
        "struct Point { x: real\n y: real\n constraint fit { root.a * x + root.b - y } }\n"
        "root Line { param a: real = 0\n param b: real = 0\n points: list of Point }\n"
    )
    (tmp_path / "points.csv").write_text("x,y\n0,0.1\n1,0.9\n2,2.2\n3,2.8\n4,4.1\n")
    files = tmp_path / "line.arael", tmp_path / "points.csv"
    done = arael("solve", *files, "--summary", "--scale", "residual", "--interpret")
    assert "degrees of freedom       3" in done.out and "residual deviation" in done.out
    found = arael("solve", *files, "--summary", "--interpret", "--json").json["report"]
    assert found["degrees_of_freedom"] == 3 and found["parameters"]["a"]["sigma"] > 0
    assert found["chi_square"] == pytest.approx(found["aic"] - 4)


BOUNDED = """
struct Part {
    param gain: real in 0 .. 5 = 1
    constraint near { gain - 9 }
}
root Rig {
    param k: real = 1
    param v: vec2 = [0, 0]
    parts: list of Part
    constraint a { k - 3 }
    constraint b { v - [1, 2] }
}
"""


def test_bounds_and_components_of_the_data_go_through_a_solve(arael: Arael, tmp_path: Path) -> None:
    model, data, out = (tmp_path / name for name in ("rig.arael", "rig.json", "out.json"))
    model.write_text(BOUNDED)
    given = {
        "k": {"value": 1, "high": 2},
        "v": {"value": [0, 0], "fixed": [True, False]},
        "parts": [{"gain": {"value": 1, "high": 7}}, {"gain": {"value": 1, "high": None}}, {}],
    }
    data.write_text(json.dumps(given))
    done = arael("solve", model, data, "--interpret", "-o", out, "--summary", "--show", "parts")
    assert done.code == 0
    text = " ".join(done.out.split())
    assert "k = 2 (on its upper bound 2)" in text and "v.x = 0 (fixed)" in text
    assert "parts[0].gain = 7 (on its upper bound 7)" in text
    found = json.loads(out.read_text())
    assert found["k"] == {"value": pytest.approx(2), "high": 2}
    assert found["v"]["fixed"] == [True, False]
    gains = [part["gain"] for part in found["parts"]]
    assert gains[0]["high"] == 7 and gains[1]["high"] is None
    assert gains[2] == pytest.approx(5)
    data.write_text(json.dumps({**given, "k": {"value": 1, "low": 2}}))
    done = arael("solve", model, data, "--interpret")
    assert (
        done.code == 1 and "error[E1007]: `k` starts at 1, outside its bounds 2 .. inf" in done.err
    )

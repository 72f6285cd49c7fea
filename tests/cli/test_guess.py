"""Commands without the name of a model: found by what stands beside the data, tags or columns."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import Arael
from tests.optional import needs

GRAPHS = {
    "pose_graph_2d": "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1.2 0 0\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
    "pose_graph_3d": "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1.2 0 0 0 0 0\nEDGE3 0 1 1 0 0 0 0 0 "
    "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n",
}
BAL = "1 1 1\n0 0 1.5 2.5\n" + "0\n" * 5 + "-5\n" + "500\n0\n0\n" + "0\n0\n1\n"


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_file_beside_the_data_comes_first(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.json", "--interpret")
    assert done.code == 0 and "b = 1.00 +-" in done.out
    assert "model: line.arael, the file of that name beside the data" in done.err
    assert arael("solve", "line.json", "--interpret", "--json").json["model"] == "line.arael"
    assert "fits the model (3 points)" in arael("check", "line.json").out


@pytest.mark.parametrize(("name", "ending"), [("pose_graph_2d", "g2o"), ("pose_graph_3d", "graph")])
def test_graphs_are_known_by_their_tags(arael: Arael, here: Path, name: str, ending: str) -> None:
    Path(f"map.{ending}").write_text(GRAPHS[name])
    done = arael("solve", f"map.{ending}", "--interpret", "--json")
    assert done.json["model"] == name and done.json["converged"]
    assert f"model: {name}, by its tags" in arael("diagnose", f"map.{ending}").err


def test_bundles_are_known_by_their_numbers(arael: Arael, here: Path) -> None:
    Path("bundle.txt").write_text(BAL)
    assert "1 cameras, 1 points, 1 observations" in arael("check", "bundle.txt").out


def test_tables_are_known_by_their_columns(arael: Arael, here: Path) -> None:
    Path("walk.csv").write_text("x,y\n0,1\n1,3\n2,5\n")
    done = arael("solve", "walk.csv", "--interpret")
    assert done.code == 0 and "a = 2.0" in done.out and "b = 1.0" in done.out
    assert "model: linear, by its columns: they are those of `data`" in done.err


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("walk.csv", "time,range\n0,1\n1,2\n", "no standard model has the columns"),
        ("path.tum", "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n", "holds a trajectory (tum)"),
        ("walk.json", '{"wheels": 3}', "no standard model has the fields"),
    ],
)
def test_what_no_model_is_for_is_refused(
    arael: Arael, here: Path, name: str, text: str, told: str
) -> None:
    Path(name).write_text(text)
    done = arael("solve", name)
    assert done.code == 2 and "E0859" in done.err and told in done.err


@needs("matplotlib")
def test_a_sketch_is_drawn_and_not_solved(arael: Arael, here: Path) -> None:
    Path("part.cmd").write_text("add_line 0,0 10,0\n")
    assert arael("sketch", "part.cmd", "--export", "part.json").code == 0
    done = arael("show", "part.json")
    assert done.out == "part.json: a sketch\nwrote part.png\n" and Path("part.png").stat().st_size
    assert "the file holds a sketch" in arael("solve", "part.json").err


def test_models_beside_the_data_are_offered(arael: Arael, line: Path) -> None:
    Path("walk.csv").write_text("time,range\n0,1\n1,2\n")
    assert "arael solve line.arael walk.csv" in arael("solve", "walk.csv").err


def test_a_missing_file_is_told_as_such(arael: Arael, here: Path) -> None:
    assert "E0712" in arael("solve", "missing.g2o").err
    assert "E0812" in arael("solve", "missing", "missing.json").err


def test_solve_alone_shows_commands_that_work(arael: Arael, here: Path) -> None:
    done = arael("solve")
    assert done.code == 2
    commands = [text.split()[1:] for text in done.out.splitlines() if text.startswith("  arael ")]
    assert [words[0] for words in commands] == ["demo", "new", "solve"]
    assert arael("new", "line").code == 0
    solved = arael("solve", "line.json", "--interpret")
    assert solved.code == 0 and "slope" in solved.out


@needs("matplotlib")
def test_plot_without_a_name_is_named_after_the_data(arael: Arael, line: Path) -> None:
    done = arael("solve", "line.json", "--interpret", "--plot")
    assert "wrote line.png" in done.out
    assert {p.name for p in line.glob("*.png")} == {"line.png", "line-cost.png", "line-hessian.png"}


@needs("matplotlib")
def test_show_draws_what_files_hold(arael: Arael, line: Path) -> None:
    assert "line.json: 3 points" in arael("show", "line.json").out
    Path("walk.csv").write_text("time,range\n0,1\n1,2\n")
    Path("path.tum").write_text("0 0 0 0 0 0 0 1\n2 3 0 4 0 0 0 1\n")
    Path("map.g2o").write_text(GRAPHS["pose_graph_2d"])
    assert "walk.csv: 2 rows of time, range" in arael("show", "walk.csv").out
    assert "path.tum: 2 poses (tum), 5 m long, 2 s" in arael("show", "path.tum").out
    found = arael("show", "map.g2o", "--view", "xy", "-o", "drawn.svg", "--json").json
    assert found == {
        "model": "pose_graph_2d",
        "rows": {"poses": 2, "edges": 1},
        "written": ["drawn.svg"],
    }
    pictures = {"line.png", "walk.png", "path.png", "drawn.svg"}
    assert pictures <= {p.name for p in line.iterdir()}
    assert "E0861" in arael("show", "map.g2o", "-o", "map.g2o").err

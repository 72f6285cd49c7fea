"""`Sketch`: the commands as methods, things as objects."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands import session
from arael.sketch.commands.replies import Reply
from tests.sketch.stand_in import StandIn


@pytest.fixture(autouse=True)
def _without_solver(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(session, "_make_editor", StandIn)


def test_importing_arael_does_not_import_the_sketch_editor() -> None:
    code = "import arael, sys; print('arael.sketch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_entities_are_objects() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    line = made.add_line((0, 0), (5, 0))
    assert (line.name, line.kind, line.length, line.angle) == ("L0", "line", 5.0, 0.0)
    assert tuple(line.p2) == (5.0, 0.0)
    assert (line.p2.x, line.p2.y, str(line.p2)) == (5.0, 0.0, "L0.p2")
    assert repr(line) == "<L0: line (0, 0)-(5, 0), length 5>"
    hole = made.add_circle(line.p2, 1.5, noconnect=True, quiet=True)
    assert (hole.radius, hole.center.x) == (1.5, 5.0)
    assert not made.document.constraints
    assert made.document.entities["A0"].quiet
    with pytest.raises(AttributeError, match="has no 'radius'"):
        _ = line.radius
    assert {"length", "p1"} <= set(dir(line))


def test_arguments_of_every_sort() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    line = made.add_line((0, 0), np.array([5.0, 0.0]), "@0,3")[0]
    made.param("w", 4)
    dimension = made.length(line, "w * 2")
    assert dimension.value == 8
    assert made.document.dimensions["d0"].value.text == "w * 2"  # type: ignore[union-attr]
    dimension.value = 7
    assert dimension.value == 7
    assert made.length("L1", ">= 2").record.low.number == 2
    assert made.length("L1", "2 to w").record.high.number == 4
    assert made.distance(line.p1, made["L1.p2"], np.float64(3.5)).value == 3.5
    assert made.horizontal(line).name == "CL0H"
    assert made.print("L0.length")["values"] == [5.0]
    assert made.measure(line)["length"] == 5.0
    made.add_point((-0.1, 1e-300))
    assert made.document.numbers_of("P0").tolist() == [-0.1, 1e-300]


def test_numbers_are_read_back_exactly() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    rng = np.random.default_rng(3)
    for x, y in rng.normal(size=(20, 2)) * 10.0 ** rng.integers(-20, 20, size=(20, 1)):
        point = made.add_point((x, y), noconnect=True)
        assert tuple(point.pos) == (x, y)


def test_a_text_is_one_word_and_no_command() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    made.add_line((0, 0), (5, 0))
    with pytest.raises(AraelError):
        made.length("L0", "3; delete L0")
    with pytest.raises(AraelError):
        made.length("L0", "3\ndelete L0")
    with pytest.raises(AraelError):
        made.length("L0", '3" "4')
    with pytest.raises(AraelError):
        made.add_line((0, 0), object())  # type: ignore[arg-type]
    assert "L0" in made


def test_undo_and_history_are_shared_with_commands() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    made.add_line((0, 0), (5, 0))
    (reply,) = made.run("length L0 3")
    assert isinstance(reply, Reply)
    assert made.document.history.labels == ["add_line 0,0 5,0", "length L0 3"]
    made.undo()
    assert not made.document.dimensions
    assert len(made) == 1
    assert [one.name for one in made] == ["L0"]
    assert repr(made) == "<Sketch: 1 entities, 0 constraints, 0 dimensions>"


def test_names_and_things() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    made.run("base = add_line 0,0 5,0")
    assert made["base"] == made["L0"]
    assert "base" in made
    line = made["L0"]
    line.delete()  # type: ignore[union-attr]
    assert repr(line) == "<L0: deleted>"
    with pytest.raises(KeyError):
        made["L0"]


def test_files_anywhere(tmp_path: Path) -> None:
    from arael.sketch import Sketch

    made = Sketch()
    made.add_rect((0, 0), (5, 3), hv=True)
    path = tmp_path / "a folder" / "x.json"
    path.parent.mkdir()
    made.save(path)
    again = Sketch(path)
    assert len(again) == 4
    assert again.session.folder == made.session.folder


def test_the_drawing_in_notebooks() -> None:
    from arael.sketch import Sketch

    made = Sketch()
    made.add_line((0, 0), (5, 0))
    assert made._repr_svg_().startswith("<svg")

"""Sketches of the benchmark: counts, the check of answers, commands, the report; no peers."""

from __future__ import annotations

import random
import re
import sys
import types
import venv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arael import AraelError
from arael.diagnostics.records import Diagnostic
from benchmarks.sketch import chapter, check, ours, sketches, writing
from benchmarks.sketch.commands import random_commands
from benchmarks.sketch.repeating import AbsentError, repeated
from benchmarks.sketch.systems import Case, Measured, Outcome, outcome, run
from benchmarks.systems import Plan

NAMES = ("chain-20", "chain-25", "polygon-8", "plate", "links-5")


def solved(sketch: sketches.Sketch, rules: tuple[sketches.Rule, ...] | None = None) -> check.State:
    """A dense Gauss-Newton by differences: slow, independent of all that is measured."""
    numbers = np.concatenate([sketch.points.ravel(), sketch.radii])
    size = sketch.points.size

    def of(x: np.ndarray) -> check.State:
        return check.State(x[:size].reshape(-1, 2), x[size:])

    for _ in range(8):
        value = check.residuals(sketch, of(numbers), rules)
        numbers = numbers - np.linalg.lstsq(jacobian(sketch, of, numbers, rules), value)[0]
    return of(numbers)


def jacobian(sketch, of, numbers, rules=None) -> np.ndarray:
    step = 1e-6 * np.eye(len(numbers))
    columns = [
        check.residuals(sketch, of(numbers + e), rules)
        - check.residuals(sketch, of(numbers - e), rules)
        for e in step
    ]
    return np.array(columns).T / 2e-6


@pytest.mark.parametrize("count", [8, 98, 503, 2001, 10009])
def test_a_chain_has_as_many_equations_as_its_name(count: int) -> None:
    chain = sketches.make(f"chain-{count}")
    assert chain.equations == chain.unknowns == count
    assert chain.freedoms == 0


@pytest.mark.parametrize("name", NAMES)
def test_rules_can_be_met_and_leave_the_freedoms_said(name: str) -> None:
    sketch = sketches.make(name)
    found = solved(sketch)
    assert check.largest(sketch, found) < 1e-9
    numbers = np.concatenate([found.points.ravel(), found.radii])
    size = sketch.points.size
    matrix = jacobian(sketch, lambda x: check.State(x[:size].reshape(-1, 2), x[size:]), numbers)
    assert len(numbers) - np.linalg.matrix_rank(matrix, tol=1e-5) == sketch.freedoms


@pytest.mark.parametrize("name", NAMES)
def test_the_changed_dimension_can_be_met(name: str) -> None:
    sketch = sketches.make(name)
    rules = sketch.with_target(sketch.targets[1])
    found = solved(sketch, rules)
    assert check.largest(sketch, found, rules) < 1e-9
    assert check.largest(sketch, found) == pytest.approx(abs(np.subtract(*sketch.targets)))


@pytest.mark.parametrize("name", ["chain-20", "plate", "polygon-8"])
def test_candidates_are_what_they_are_called(name: str) -> None:
    sketch = sketches.make(name)
    found = solved(sketch)
    for word, rule in sketch.candidates.items():
        more = (*sketch.rules, rule)
        again = check.largest(sketch, solved(sketch, more), more)
        if word == "contradicting":
            assert again > 0.1
            continue
        assert again < 1e-9
        assert (check.largest(sketch, found, more) < 1e-9) == (word == "redundant")


def test_a_displaced_point_is_a_residual_of_its_size() -> None:
    sketch = sketches.make("plate")
    found = solved(sketch)
    for point in range(len(sketch.points)):
        points = found.points.copy()
        points[point] += (3e-3, 4e-3)
        assert 1e-3 < check.largest(sketch, replace(found, points=points)) < 1e-2


def test_a_missing_number_is_no_solution() -> None:
    sketch = sketches.make("chain-20")
    found = solved(sketch)
    found.points[2, 0] = np.nan
    assert check.largest(sketch, found) == np.inf


def test_numbers_of_entities_are_put_together() -> None:
    sketch = sketches.make("plate")
    found = solved(sketch)
    p, r = found.points, np.full(4, 6.0)
    said = {
        "lines": p[np.array(sketch.lines)].ravel().tolist(),
        "circles": np.column_stack([p[list(sketch.circles)], found.radii]).ravel().tolist(),
        "arcs": np.column_stack([p[np.array(sketch.arcs)].reshape(4, 6), r]).ravel().tolist(),
    }
    state = check.state(sketch, said)
    np.testing.assert_array_equal(state.points, p)
    np.testing.assert_array_equal(state.radii, found.radii)
    assert state.apart < 1e-9
    said["lines"][0] += 0.25  # an end that came away from the point it shares
    assert check.state(sketch, said).apart == pytest.approx(0.25)


def test_the_polygon_takes_512_commands_in_the_words_of_the_language() -> None:
    script = writing.script(sketches.make("polygon-128"))
    assert len(script) == 512
    words = [line.split()[0] for line in script]
    assert [words.count(w) for w in ("add_line", "add_circle", "equal", "length", "radius")] == [
        128,
        128,
        254,
        1,
        1,
    ]
    assert script[-1] == "radius A0 0.25"
    assert script[256] == "equal L0 L1"
    assert script[383] == "equal A0 A1"


def test_commands_of_the_plate_name_arcs_behind_circles() -> None:
    plate = sketches.make("plate")
    script = writing.script(plate)
    assert script[9].startswith("add_arc ")
    assert script[9].endswith(" notangent")
    assert "lock A0.center 0.0,0.0" in script
    assert "tangent L0 A5" in script
    assert "radius A5 6.0" in script
    assert "equal A5 A6" in script
    assert "radius A4 8.0" in script
    assert "distance A0.center A4.center 30.0" in script


def test_the_cursor_of_a_drag_comes_back() -> None:
    links = sketches.make("links-20")
    np.testing.assert_array_equal(links.path[-1], links.points[links.grabbed])
    assert np.linalg.norm(links.path, axis=1).max() < 20  # within reach of its links
    assert check.largest(links, check.State(links.points, links.radii)) < 1e-12


def test_lines_for_other_languages_hold_everything() -> None:
    plate = sketches.make("plate")
    words = [line.split()[0] for line in writing.lines(plate)]
    assert words.count("point") == len(plate.points)
    assert words.count("arc") == 4
    assert words.count("rule") == len(plate.rules)
    assert words.count("command") == len(writing.script(plate))
    assert f"change {len(plate.rules) - 1} 60.0 62.0" in writing.lines(plate)
    assert "stem length L0" in writing.lines(plate)


@pytest.mark.parametrize("name", ["chain", "plate-3", "circle-8", "chain-x"])
def test_an_unknown_sketch_is_reported(name: str) -> None:
    with pytest.raises(ValueError, match="no sketch"):
        sketches.make(name)


def test_random_commands_are_one_sequence_to_a_seed() -> None:
    plate = sketches.make("plate")
    first, again = (random_commands(plate, random.Random(3)) for _ in range(2))
    commands = [next(first) for _ in range(300)]
    assert commands == [next(again) for _ in range(300)]
    assert len({command.split()[0] for command in commands}) > 15
    words = [word for command in commands for word in command.replace(",", " ").split()]
    assert all(re.fullmatch(r"[a-z_]+|[LA]\d+(\.\w+)?|-?\d+\.\d+", word) for word in words)


def test_a_part_that_counts_is_taken_instead_of_the_whole() -> None:
    assert set(repeated(0.001, lambda _: 7.0)) == {7.0}
    assert len(repeated(0.01, lambda _: None)) >= 5


class Part:
    """An editor with one method."""

    def run(self, words: str) -> str:
        return f"{len(words.splitlines())} commands"


def test_a_part_that_our_editor_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    module = types.ModuleType("arael.sketch")
    monkeypatch.setitem(sys.modules, "arael.sketch", module)
    with pytest.raises(AbsentError, match="the editor is not there: cannot import name 'Sketch'"):
        ours.TASKS["resolve"](sketches.make("chain-20"), 0.001)
    module.Sketch = Part  # type: ignore[attr-defined]
    with pytest.raises(AbsentError, match="Sketch has no length yet"):
        ours.TASKS["resolve"](sketches.make("chain-20"), 0.001)


def test_a_script_that_our_editor_refuses_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Part, words: str) -> str:
        raise AraelError(Diagnostic("E0101", "no such command"))

    module = types.ModuleType("arael.sketch")
    monkeypatch.setattr(Part, "run", refuse)
    module.Sketch = Part  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "arael.sketch", module)
    with pytest.raises(AbsentError, match=r"the script was refused: .*no such command"):
        ours.TASKS["script"](sketches.make("plate"), 0.001)


@pytest.mark.parametrize(
    ("task", "name", "said"),
    [
        ("resolve", "chain-20", "d0"),
        ("freedom", "chain-20", "0 degrees of freedom"),
        ("edit", "chain-20", "length L0"),
        ("redundant", "chain-20", "error[E1230]"),
        ("contradicting", "chain-20", "error[E1231]"),
        ("script", "links-5", "11 commands"),
        ("drag", "links-5", "one gesture"),
        ("undo", "chain-20", "0 not undone, 0 exceptions"),
    ],
)
def test_tasks_of_our_editor(task: str, name: str, said: str) -> None:
    sketch = sketches.make(name)
    found = ours.TASKS[task](sketch, 0.001)
    assert said in found["said"]
    assert len(found["times"]) == {"script": 1, "drag": 40}.get(task, len(found["times"]))
    assert found["times"]
    if task != "undo":
        assert outcome(sketch, task, found).residual < 1e-9


def test_an_answer_is_not_believed() -> None:
    sketch = sketches.make("chain-20")
    said = {"times": [1e-3], "said": "solved", "settings": "", "version": "a peer"}
    drawn = {"points": sketch.points.ravel().tolist(), "radii": []}
    assert outcome(sketch, "resolve", {**said, "answer": drawn}).residual > 0.9
    rules = sketch.with_target(sketch.targets[1])
    right = {"points": solved(sketch, rules).points.ravel().tolist(), "radii": []}
    assert outcome(sketch, "resolve", {**said, "answer": right}).residual < 1e-9
    assert outcome(sketch, "edit", {"absent": "not there"}).reason == "not there"


def test_a_wheel_that_is_missing_is_named(tmp_path: Path) -> None:
    venv.create(tmp_path / "bare", with_pip=False)  # whatever this one has installed
    plan = Plan(sketchers=("slvs",), quick=True, python=str(tmp_path / "bare/bin/python"))
    found = run("slvs", Case("resolve", "chain-20"), plan, tmp_path)
    assert found.reason.startswith("slvs is not installed: `pip install slvs`")


def test_the_report_has_ratios_of_one_run_and_reasons() -> None:
    ours = Outcome((1e-3, 2e-3, 3e-3), 1e-12, 0.0, "", 0, "arael 0", "to 1e-10")
    peer = Outcome((5e-3,), 1e-9, 0.1, "solved", None, "peer 1", "to 1e-8")
    gone = Outcome(reason="not built")
    measured = [
        Measured(Case("freedom", "chain-20", "3"), {"arael": ours, "ezpz": peer, "slvs": gone}),
        Measured(Case("drag", "links-5"), {"arael": gone, "ezpz": peer, "slvs": gone}),
    ]
    text = "\n".join(chapter.report(measured))
    assert "| chain-20 | 2 (1-3) | 5 | - | 3 |" in text
    assert "| chain-20 | 1.0 | 2.5 | - |" in text
    assert "| chain-20 | 1.0e-12 | 1.0e-09 | - |" in text
    assert "| chain-20 | 0 | - | - | 0 |" in text
    assert "- slvs: freedom chain-20, drag links-5: not built" in text
    assert "| chain-20 | 20 | 20 | 0 | 12 | 0 | 0 |" in text

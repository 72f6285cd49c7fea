"""check, fmt, info, emit, explain, cache, doctor, new."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path

import pytest

from tests.cli.conftest import MODEL, Arael


def test_check_accepts(arael: Arael, line: Path) -> None:
    done = arael("check", "line.arael", "line.json")
    assert done.code == 0
    assert "line.arael: no errors" in done.out
    assert "3 points" in done.out


def test_check_refuses_a_model(arael: Arael, line: Path) -> None:
    (line / "line.arael").write_text(MODEL.replace("p.y", "p.z"))
    done = arael("check", "line.arael")
    assert done.code == 2
    assert "line.arael:12" in done.err
    assert "^" in done.err


def test_check_refuses_data(arael: Arael, line: Path) -> None:
    (line / "line.json").write_text('{"a": 0, "b": 0, "points": [{"x": 1}]}')
    done = arael("check", "line.arael", "line.json", "--json")
    assert done.code == 2
    assert done.json["diagnostics"][0]["code"].startswith("E07")


def test_check_json(arael: Arael, line: Path) -> None:
    found = arael("check", "line.arael", "line.json", "--json").json
    assert found["status"] == "ok"
    assert found["rows"] == {"points": 3}


def test_check_needs_no_compiler(arael: Arael, line: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "/no/such/compiler")
    assert arael("check", "line.arael", "line.json").code == 0


@pytest.mark.slow
def test_gradients_agree_on_the_standard_models(arael: Arael, tmp_path: Path) -> None:
    import arael as package
    from arael.scenes import columns, demo_config, fill, make_scene

    scene = make_scene(demo_config(6))
    for name in ("slam", "localization"):
        model = package.load(name, interpret=True)
        instance = model()
        fill(instance, model.layout, columns(scene, name))
        package.write(instance, tmp_path / "scene.npz")
        done = arael("check", name, tmp_path / "scene.npz", "--gradients", "--json")
        assert done.code == 0, done.err
        assert len(done.json["gradients"]) == len(model.layout.groups)
        assert max(done.json["gradients"].values()) < 1e-6


def test_a_jump_is_found(arael: Arael, line: Path) -> None:
    (line / "line.arael").write_text(MODEL.replace("(a *", "(floor(a) *"))
    (line / "line.json").write_text(
        '{"a": 2, "b": 0, "points": [{"x": 0, "y": 0}, {"x": 1, "y": 1}]}'
    )
    done = arael("check", "line.arael", "line.json", "--gradients")
    assert done.code == 2
    assert "E0630" in done.err
    assert "Line.points[1] at points[1]" in done.err
    assert "the derivative by `" in done.err


def test_gradients_need_data(arael: Arael, line: Path) -> None:
    done = arael("check", "line.arael", "--gradients")
    assert done.code == 2
    assert "--gradients needs DATA" in done.err


UGLY = "root  R{\nparam a:real\nconstraint c{a-1}\n}\n"


def test_fmt_in_place_is_idempotent(arael: Arael, line: Path) -> None:
    file = line / "ugly.arael"
    file.write_text(UGLY)
    assert "formatted" in arael("fmt", "ugly.arael").out
    once = file.read_text()
    assert once != UGLY
    assert arael("fmt", "ugly.arael").out == ""
    assert file.read_text() == once


def test_fmt_check_and_diff_write_nothing(arael: Arael, line: Path) -> None:
    file = line / "ugly.arael"
    file.write_text(UGLY)
    checked, shown = arael("fmt", "--check", "ugly.arael"), arael("fmt", "--diff", "ugly.arael")
    assert (checked.code, shown.code) == (1, 1)
    assert "would format ugly.arael" in checked.out
    assert "-param a:real" in shown.out
    assert file.read_text() == UGLY


def test_fmt_keeps_the_mode_of_the_file(arael: Arael, line: Path) -> None:
    file = line / "ugly.arael"
    file.write_text(UGLY)
    file.chmod(0o640)
    arael("fmt", "ugly.arael")
    assert file.stat().st_mode & 0o777 == 0o640


def test_fmt_of_a_folder_tells_every_broken_file(arael: Arael, line: Path) -> None:
    (line / "bad1.arael").write_text("root R {")
    (line / "bad2.arael").write_text("struct {}")
    done = arael("fmt", "--check", ".")
    assert done.code == 2
    assert "bad1.arael" in done.err
    assert "bad2.arael" in done.err


def test_fmt_of_standard_input(arael: Arael, line: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import io

    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(UGLY.encode())))
    done = arael("fmt", "-")
    assert done.code == 0
    assert "param a: real" in done.out
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"root R {\n  param a real\n}\n")))
    assert "--> <stdin>:2:10" in arael("fmt", "-").err


def test_standard_models_are_formatted(arael: Arael) -> None:
    folder = Path(__file__).parents[2] / "models"
    assert arael("fmt", "--check", folder).code == 0


def test_info(arael: Arael, line: Path) -> None:
    done = arael("info", "line.arael")
    assert done.code == 0
    for text in ("param a", "points: list of Point", "Line at root: 2 per row (a, b)", "fine: "):
        assert text in done.out
    found = arael("info", "line.arael", "--json").json
    assert found["root"] == "Line"
    constraint = found["constraints"][0]
    assert constraint["operations_before"] >= constraint["residuals"] > 0


def test_info_shows_skip_on_values_and_refs(arael: Arael, tmp_path: Path) -> None:
    model = tmp_path / "rig.arael"
    model.write_text(
        "struct P { param x: real; skip note: string; skip left: ref P in root.ps\n"
        "right: ref P in root.ps\nconstraint c { x - right.x } }\nroot R { ps: list of P }\n"
    )
    shown = arael("info", str(model)).out
    assert "skip note" in shown and "skip left" in shown and "skip right" not in shown
    (table,) = [t for t in arael("info", str(model), "--json").json["tables"] if t["path"] == "ps"]
    assert [f["path"] for f in table["fields"] if f["skip"]] == ["note", "left"]


def test_info_lists_ties_priors_bounds_and_what_is_held(arael: Arael, tmp_path: Path) -> None:
    model = tmp_path / "rig.arael"
    model.write_text(
        """
        struct Pose {
            param pos: vec3 in -1 .. 5 = [0, 0, 0]
            m: vec3
            fixed pos.z
            prior pos ~ normal(m,
                               2) when m.x > 0 loss cauchy(1)
            constraint c { pos - m }
        }
        root R {
            param f: real in 0 .. = 500
            # The other focal length.
            param fy = 1.02 * f
            poses: list of Pose
            constraint d { fy - 3 }
            solve { pass a { freeze poses } pass b { } }
        }
        """
    )
    shown = arael("info", model).out
    for line in (
        "param f  real  in 0 ..  = 500",
        "param pos  vec3  in -1 .. 5  = 0, 0, 0  fixed z",
        "  R.fy = 1.02 * f  (",
        "    The other focal length.",
        "  Pose.pos ~ normal(m, 2) when m.x > 0 loss cauchy(1)  (",
        "  Pose.pos.z  (",
        "  a: freeze poses",
    ):
        assert line in shown, shown
    found = arael("info", model, "--json").json
    (tie,), (prior,), (fixed,) = found["derived"], found["priors"], found["fixed"]
    assert tie["struct"] == "R" and tie["name"] == "fy" and tie["formula"] == "1.02 * f"
    assert prior["distribution"].startswith("normal(m, 2)") and fixed["name"] == "pos.z"
    assert found["freezes"] == [{"pass": "a", "freeze": ["poses"], "free": []}]
    (field,) = [f for f in found["tables"][1]["fields"] if f["path"] == "pos"]
    assert field["low"] == [-1] * 3 and field["high"] == [5] * 3
    assert "derived" not in arael("info", "linear").out


def test_emit_of_a_long_sum_is_cut_below_a_depth(arael: Arael, tmp_path: Path) -> None:
    model = tmp_path / "long.arael"
    model.write_text("root R { param x: real; constraint c { " + " + ".join(["x"] * 800) + " } }\n")
    for stage in ("ast", "types"):
        assert "..." in arael("emit", str(model), "--stage", stage).out


def test_info_of_slam_shows_documentation_and_guards(arael: Arael) -> None:
    done = arael("info", "slam")
    assert "GPS fixes, where there are any." in done.out
    assert "Pose.gps when info.gps: 3 residuals" in done.out


@pytest.mark.parametrize(
    ("stage", "expected"),
    [
        ("ast", "Struct kind='root'"),
        ("types", "TypedModel name='line'"),
        ("ir", "d r0 / d root.a = t"),
        ("pyx", "# cython: language_level=3"),
        ("c", "Generated by Cython"),
    ],
)
def test_emit(arael: Arael, line: Path, stage: str, expected: str) -> None:
    done = arael("emit", "line.arael", "--stage", stage)
    assert done.code == 0
    assert expected in done.out


def test_emit_is_deterministic(arael: Arael) -> None:
    assert arael("emit", "slam").out == arael("emit", "slam").out


def test_explain(arael: Arael) -> None:
    assert arael("explain", "e0852").out.startswith("# E0852")
    listed = arael("explain").out.splitlines()
    assert any(text.startswith("E0852: ") for text in listed)
    unknown = arael("explain", "E0849")
    assert unknown.code == 2
    assert "there is no diagnostic" in unknown.err


OWN = (
    "E0630",
    "E0850",
    "E0852",
    "E0853",
    "E0854",
    "E0855",
    "E0856",
    "E0857",
    "E0859",
    "E0860",
    "E0861",
)


def test_every_code_of_the_command_line_is_explained(arael: Arael) -> None:
    folder = Path(__file__).parents[2] / "arael"
    text = "".join(
        file.read_text()
        for package in ("cli", "plot", "demo", "scenes")
        for file in sorted((folder / package).glob("*.py"))
    )
    for code in OWN:
        assert f'"{code}"' in text
        assert arael("explain", code).code == 0


def test_cache(arael: Arael, line: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(tmp_path / "cache"))
    assert arael("cache", "info", "--json").json["entries"] == []
    arael("solve", "line.arael", "line.json")
    entry = arael("cache", "info", "--json").json["entries"][0]
    assert entry["name"] == "line"
    assert entry["bytes"] > 0
    assert "line.arael" in arael("cache", "info").out
    assert "removed 1 compiled model," in arael("cache", "clear").out
    assert arael("cache", "info", "--json").json["entries"] == []


def test_doctor(arael: Arael) -> None:
    done = arael("doctor", "--json")
    found = {f["name"]: f for f in done.json["findings"]}
    assert done.code == 0
    named = {"python", "numpy", "scipy", "C compiler", "processor", "threads", "BLAS", "cache"}
    assert named <= set(found)
    assert found["C compiler"]["state"] == "ok"


def test_doctor_without_a_compiler(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "/no/such/compiler")
    done = arael("doctor")
    assert done.code == 0
    assert "CC=/no/such/compiler not found" in done.out
    assert "expression machine" in done.out


def test_doctor_with_a_broken_compiler(arael: Arael, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "false")
    done = arael("doctor")
    assert done.code == 2
    assert "! C compiler" in done.out


@pytest.mark.skipif(os.name == "nt", reason="modes are of POSIX")
def test_doctor_on_a_cache_that_others_can_write(
    arael: Arael, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(shared))
    done = arael("doctor")
    assert done.code == 2
    assert "`arael cache clear`" in done.out


def test_new_can_be_solved_and_overwrites_nothing(arael: Arael, line: Path) -> None:
    assert arael("new", "my_fit").code == 0
    assert "loss cauchy(2)" in Path("my_fit.arael").read_text(encoding="utf-8")  # no patented one
    assert arael("fmt", "--check", "my_fit.arael").code == 0
    assert arael("solve", "my_fit.arael", "my_fit.json", "-o", "out.json").code == 0
    solved = json.loads((line / "out.json").read_text())
    assert solved["slope"] == pytest.approx(2.0, abs=0.02)
    assert solved["offset"] == pytest.approx(1.0, abs=0.03)
    again = arael("new", "my_fit")
    assert again.code == 2
    assert "E0854" in again.err


@pytest.mark.parametrize("name", ["a b", "../x", "1st", ""])
def test_new_refuses_odd_names(arael: Arael, line: Path, name: str) -> None:
    assert arael("new", name).code == 2


ANGLES = """
struct Pose { param heading: angle
              constraint seen { rad_diff(heading, 1) } }
root Track { poses: list of Pose }
"""


def test_solve_and_check_ask_about_degrees(arael: Arael, tmp_path: Path) -> None:
    (tmp_path / "m.arael").write_text(ANGLES)
    (tmp_path / "d.json").write_text(json.dumps({"poses": [{"heading": 90}]}))
    paths = (tmp_path / "m.arael", tmp_path / "d.json")
    for command in (("solve", *paths, "--interpret"), ("check", *paths)):
        with warnings.catch_warnings():
            warnings.simplefilter("default")
            done = arael(*command)
        assert done.code == 0
        assert done.err.count("warning[W0702]: an angle of 90 rad: degrees?") == 1

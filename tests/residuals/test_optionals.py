"""Optionals in runtime residuals, behind `when` and `if`, against constraints of a model file."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import arael
from arael.diagnostics.records import AraelError

MODEL = """
struct Gps { pos: vec2; quality: real? }
struct Pose {
    param pos: vec2
    height: real?
    aim: vec2?
    gps: Gps?
    prev: ref Pose in root.poses?
    constraint keep { (pos - pos.value) * 0.1 }
    %s
}
root Path {
    poses: list of Pose
    offset: vec2?
    param scale: real = 1
    constraint unit { scale - 1 }
}
"""
# label -> guard, residual as a constraint of Pose; `pos` stands for `p.pos` at run time.
CASES = {
    "high": ("height", "pos.x * scale - height"),
    "aimed": ("aim", "(pos - aim) * 0.5"),
    "far": ("aim and aim.x > 1", "norm2(pos - aim) * scale"),
    "fixed": ("gps", "pos - gps.pos"),
    "good": ("gps and gps.quality", "(pos - gps.pos) * gps.quality"),
    "none": ("not gps", "pos * 0.3"),
    "step": ("prev", "pos - prev.pos - [1, 0]"),
    "bent": ("prev and prev.prev", "pos - 2 * prev.pos + prev.prev.pos"),
    "shared": ("prev.gps", "pos - prev.gps.pos"),
    "either": ("", "pos.y - (if height then height else 2)"),
    "both": ("", "pos.y * (if gps and gps.quality then gps.quality else 0)"),
    "there": ("", "pos.x * (if prev then 1 else 0.5)"),
    "moved": ("offset", "pos - offset"),
    "robust": ("height", "pos.y - height loss huber(1)"),
}
FIELDS = ("pos", "height", "aim", "gps", "prev")
SHARED = {"scale": "root.scale", "offset": "root.offset"}


def written(text: str, names: dict[str, str]) -> str:
    """`text` with other names where a name stands by itself, not behind a dot."""
    return re.sub(r"(?<![\w.])([a-z]\w*)", lambda m: names.get(m[1], m[1]), text)


@pytest.fixture(
    scope="module", params=["interpreted", pytest.param("kernels", marks=pytest.mark.slow)]
)
def models(
    tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest
) -> tuple[type, type]:
    """The model with all constraints, and the one without."""
    folder = tmp_path_factory.mktemp("optionals")
    lines = []
    for label, (guard, text) in CASES.items():
        when = f"when {guard}" if guard else ""
        body, _, loss = text.partition(" loss ")
        loss = f"loss {loss}" if loss else ""
        lines.append(written(f"constraint {label} {when} {loss} {{ {body} }}", SHARED))
    (folder / "whole.arael").write_text(MODEL % "\n    ".join(lines))
    (folder / "part.arael").write_text(MODEL % "")
    whole = arael.load(folder / "whole.arael", interpret=request.param == "interpreted")
    return whole, arael.load(folder / "part.arael", interpret=True)


def filled(model: type, n: int = 40) -> Any:
    """Poses of which each has some optionals, and lacks others."""
    rng = np.random.default_rng(5)
    path = model(scale=1.1, offset=[0.5, 0.25])
    for k in range(n):
        gps = {"pos": rng.normal(size=2), "quality": 0.5 + k if k % 3 else None}
        path.poses.append(
            pos=rng.normal(size=2),
            height=rng.normal() if k % 2 else None,
            aim=rng.normal(size=2) + 1 if k % 5 else None,
            gps=gps if k % 4 else None,
            prev=k - 1 if k % 7 else None,
        )
    return path


def with_residuals(model: type) -> Any:
    path = filled(model)
    names = {field: f"p.{field}" for field in FIELDS}
    for label, (guard, text) in CASES.items():
        body, _, loss = text.partition(" loss ")
        path.residuals.add(
            written(body, names),
            label=label,
            entities={"p": path.poses},
            loss=loss or None,
            when=written(guard, names) or None,
        )
    return path


def test_they_are_what_constraints_are(models: tuple[type, type]) -> None:
    whole, part = filled(models[0]), with_residuals(models[1])
    costs, instances = whole.cost_table(), part.cost_table().instances
    for label in CASES:
        assert part.residuals[label].cost == pytest.approx(costs[f"Pose.{label}"], rel=1e-12)
        assert instances[label] == costs.instances[f"Pose.{label}"]
    np.testing.assert_allclose(whole.gradient(), part.gradient(), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(
        np.asarray(whole.hessian()), np.asarray(part.hessian()), rtol=1e-11, atol=1e-11
    )


def test_they_lead_to_the_same_optimum(models: tuple[type, type]) -> None:
    found = []
    for path in (filled(models[0]), with_residuals(models[1])):
        path.solve(rel_precision=1e-14, max_iters=200)
        path.poses[3].height = None
        path.poses[4].prev = None
        path.poses[5].gps = {"pos": [1, 2], "quality": 3.0}
        path.offset = None
        path.solve(rel_precision=1e-14, max_iters=200)
        found.append(np.append(path.poses.pos.value.ravel(), path.cost()))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-6, atol=1e-6)


def test_kernels_of_their_own_agree_with_the_machine(models: tuple[type, type]) -> None:
    machine, compiled = with_residuals(models[1]), with_residuals(models[1])
    compiled.residuals.compile("good", "step", "either")
    assert compiled.cost() == pytest.approx(machine.cost(), rel=1e-12)
    np.testing.assert_allclose(compiled.gradient(), machine.gradient(), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("text", ["p.pos.x - p.height", "p.pos - p.aim", "p.pos - p.gps.pos"])
def test_without_a_guard_every_row_must_have_it(models: tuple[type, type], text: str) -> None:
    path = filled(models[1])
    path.residuals.add(text, label="r", entities={"p": path.poses})
    with pytest.raises(AraelError, match="is absent") as failure:
        path.solve()
    assert failure.value.diagnostics[0].code == "E0765"
    path.residuals.remove("r")
    path.residuals.add(text, label="r", entities={"p": path.poses[11]})
    assert path.residuals["r"].cost > 0


def test_a_guard_proves_no_more_than_it_asks(models: tuple[type, type]) -> None:
    path = filled(models[1])
    some = path.residuals.add(
        "p.pos.x - p.height", label="r", entities={"p": path.poses}, when="p.gps"
    )
    with pytest.raises(AraelError) as failure:
        path.cost()
    assert failure.value.diagnostics[0].code == "E0765"
    some.when = "p.gps and p.height"
    assert path.cost_table().instances["r"] == 20
    some.when = "p.gps.quality > 1"  # read where nothing has asked for it
    with pytest.raises(AraelError) as failure:
        path.cost()
    assert failure.value.diagnostics[0].code == "E0765"


def test_a_guard_is_exchanged_or_refused_whole(models: tuple[type, type]) -> None:
    path = filled(models[1])
    one = path.residuals.add("p.pos", label="r", entities={"p": path.poses}, data={"w": range(40)})
    one.when = "w >= 38"
    assert path.cost_table().instances["r"] == 2
    for bad in ("w +", "w", "p.pos.x > 0", 3):
        with pytest.raises(AraelError):
            one.when = bad  # type: ignore[assignment]
    assert one.when == "w >= 38"
    one.set_data(w=range(1, 41))
    assert path.cost_table().instances["r"] == 3
    one.when = None
    assert path.cost_table().instances["r"] == 40


def test_a_named_expression_asks_too(models: tuple[type, type]) -> None:
    path = filled(models[1])
    path.residuals.define(
        "level", "if p.height then p.height else 7", entities={"p": path.poses[2]}
    )
    assert path.residuals.value("level") == 7
    path.poses[2].height = 3.0
    assert path.residuals.value("level") == 3


@pytest.mark.parametrize("given", [lambda p: p, None, 3.5, np.zeros(2)])
def test_only_text_and_residuals_are_added(models: tuple[type, type], given: Any) -> None:
    path = filled(models[1], 2)
    with pytest.raises(AraelError, match="expected a formula as text") as failure:
        path.residuals.add(given)
    assert failure.value.diagnostics[0].code == "E0760"
    assert not path.residuals


@pytest.mark.parametrize("name", ["poses", "scale", "poses.count"])
def test_a_name_of_the_model_cannot_be_defined(models: tuple[type, type], name: str) -> None:
    path = filled(models[1], 2)
    with pytest.raises(AraelError, match="belongs to the model") as failure:
        path.residuals.define(name, "1")
    assert failure.value.diagnostics[0].code == "E0760"
    path.residuals.add("poses[0].pos.x * scale - 1")

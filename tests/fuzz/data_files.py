"""A data file: read whole, or refused with nothing changed; written, it reads as the same."""
# ruff: noqa: E501 - data as it stands in files

from __future__ import annotations

import json
import random
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from arael import io
from arael.compiler import compiler
from arael.diagnostics.records import AraelError, Findings, Source
from arael.runtime.layout import LAYOUT_VERSION, Layout
from arael.runtime.store import Store
from tests.fuzz.corpus import ROOT

MODEL = """
struct Gps { at: vec2; cov: mat2 = [[1, 0], [0, 1]] }
struct Pose {
    param p: vec3
    param e: euler
    param q: quaternion
    param a: real in 0 .. 10
    w: real = 1
    on: bool = true
    n: int
    gps: Gps?
    near: list of Near
}
struct Near { d: real; to: ref Pose in root.poses }
struct Mark {
    key name
    name: string
    param at: vec2
    seen: list of Seen
}
struct Seen { pose: ref Pose in root.poses; mark: ref Mark in root.marks; pixel: vec2 }
struct Pair { x: real; y: real; name: string; k: int }
root R {
    scale: real = 2
    poses: deque of Pose
    marks: arena of Mark
    pairs: list of Pair
}
"""

SCENE: dict[str, Any] = {
    "scale": 2.5,
    "poses": [
        {
            "p": {"value": [0, 0, 0.5], "fixed": True}, "e": [0, 0, 0], "q": [1, 0, 0, 0], "a": 4, "n": 3,
            "gps": {"at": [1, 2], "cov": [[1, 0.5], [0.5, 1]]}, "near": [{"d": 1e-3, "to": 1}],
        },
        {"p": [1, 1, 1], "e": [0.1, 0.2, 0.3], "q": [0, 0.6, 0, 0.8], "a": {"value": 0}, "n": -7,
         "on": False, "near": []},
    ],
    "marks": [
        {"name": "tree", "at": [1, 2], "seen": [{"pose": 1, "mark": "sign", "pixel": [3, 4]}]},
        {"name": "sign", "at": [-1, 1e-8], "seen": []},
    ],
    "pairs": [{"x": 1, "y": 2, "name": "a,\"b\"", "k": 1}, {"x": 3.5, "y": -1e300, "name": "é", "k": 2}],
}  # fmt: skip

G2O_2D = """\
# a comment
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1 0.5 0.25
VERTEX_SE2 7 -2 1e-3 3.1
FIX 0
EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1
EDGE_SE2 1 7 1 0.5 0 2 0.5 0 1 0 3
EDGE_PRIOR_SE2 0 0 0 0 1 0 0 1 0 1
"""
G2O_3D = """\
VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1
VERTEX_SE3:QUAT 1 1 0.5 0.25 0 0.6 0 0.8
EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1
"""
BAL = "2 1 2\n0 0 -1.5 2.0\n1 0 3.25 -4.5\n" + "\n".join(
    [
        "0.1",
        "-0.2",
        "0.3",
        "1",
        "2",
        "-3",
        "500",
        "1e-3",
        "-2e-5",
        "0",
        "0",
        "0",
        "0",
        "0.5",
        "0",
        "400",
        "0",
        "0",
        "0.5",
        "-0.25",
        "-8",
    ]
)
CSV = 'x,y,name,k\n1,2,"a,""b""",1\n3.5,-1e300,é,2\n,,,\n'.replace(",,,\n", "0,0,,0\n")


@cache
def _layout(text: str) -> Layout:
    typed = compiler.types(compiler.syntax(Source("model.arael", text)), Findings())
    return Layout(
        LAYOUT_VERSION, typed.name, typed.root, typed.precision, "model.arael", typed.tables, (), (), typed.passes,
    )  # fmt: skip


def layout_for(name: str) -> Layout:
    """The model for a file of that name."""
    standard = {
        "g2o2.g2o": "pose_graph_2d",
        "g2o3.g2o": "pose_graph_3d",
        "bal.bal": "bundle_adjustment",
    }
    if name not in standard:
        return _layout(MODEL)
    return _layout((ROOT / "models" / f"{standard[name]}.arael").read_text(encoding="utf-8"))


@cache
def originals() -> dict[str, bytes]:
    """File name -> content that is right."""
    texts = {"scene.json": json.dumps(SCENE, indent=1), "pairs.csv": CSV, "g2o2.g2o": G2O_2D,
             "g2o3.g2o": G2O_3D, "bal.bal": BAL}  # fmt: skip
    return {name: text.encode() for name, text in texts.items()} | {"scene.npz": _archive()}


def _archive() -> bytes:
    from arael.io import json_reader, npz_writer

    store = Store(_layout(MODEL))
    json_reader.read(store, json.dumps(SCENE).encode(), "scene.json")
    return npz_writer.dump(store)


def warm_up(folder: Path) -> None:
    """Read every original, so that what is imported is not counted as an input's memory."""
    for name, content in originals().items():
        assert examine(content, name, random.Random(0), folder).startswith("read"), name
    np.zeros(2_000_000).sum()


def examine(content: bytes, name: str, rng: random.Random, folder: Path) -> str:
    """Read a file into a model that holds data."""
    layout, good = layout_for(name), originals()[name]
    path = folder / name
    store = Store(layout)
    path.write_bytes(good)
    io.read(store, path)
    before = state(store, folder)
    path.write_bytes(content)
    try:
        io.read(store, path)
    except AraelError as error:
        assert len(error.diagnostics) <= 21, f"{len(error.diagnostics)} diagnostics"
        assert state(store, folder) == before, "a refused file changed the model"
        raise
    try:
        io.write(store, path)
    except AraelError as error:
        return f"read {name}, not written: {error.diagnostics[0].code}"
    once = state(store, folder)
    again = Store(layout)
    if name == "pairs.csv":  # holds one collection only
        io.read(again, folder / "state.json")
    io.read(again, path)
    assert same(state(again, folder), once, exact=name in ("scene.json", "scene.npz")), (
        "written, it reads as other data"
    )
    return f"read {name}"


def state(store: Store, folder: Path) -> bytes:
    """All data of a model."""
    io.write(store, folder / "state.json")
    return (folder / "state.json").read_bytes()


def same(a: bytes, b: bytes, exact: bool) -> bool:
    """Whether two states are equal; formats that turn rotations into others round.

    A quaternion is the same rotation as its negative.
    """
    return a == b or (not exact and _close(json.loads(a), json.loads(b)))


def _close(a: Any, b: Any) -> bool:
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(_close(a[k], b[k]) for k in a)
    if isinstance(a, list) and isinstance(b, list):
        turned = [-x for x in b] if len(b) == 4 and all(isinstance(x, float) for x in b) else b
        return len(a) == len(b) and (all(map(_close, a, b)) or all(map(_close, a, turned)))
    if isinstance(a, (int, float)) and isinstance(b, (int, float)):
        return abs(a - b) <= 1e-6 * max(1.0, abs(a), abs(b))
    return bool(a == b)

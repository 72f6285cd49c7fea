"""The chapter on exported code."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import arael
from arael.exporting import Export, export
from benchmarks.measure import table
from benchmarks.systems import Plan

HERE = Path(__file__).parent
BOARD = "-mcpu=cortex-m7 -mthumb -mfloat-abi=hard -mfpu=fpv5-d16 -Os -ffp-contract=off"


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Lines of the chapter."""
    parts = [("evaluation beside Ceres", _ceres), ("a window of ten poses", _window)]
    parts.append(("the same window on a Cortex-M7", _board))
    lines = ["## export", ""]
    for title, part in parts:
        with tempfile.TemporaryDirectory() as folder:
            try:
                lines += [f"### {title}", "", *part(Path(folder)), ""]
            except FileNotFoundError as missing:
                lines += [f"### {title}", "", f"Not measured: {missing.filename} is missing.", ""]
    return lines


def window(poses: int = 10) -> Any:
    """A chain of planar poses with a loop and an anchor."""
    model: Any = arael.load("pose_graph_2d")()  # type: ignore[call-arg]
    rng = np.random.default_rng(1)
    x = np.stack([np.arange(poses), np.zeros(poses)], axis=1) + 0.1 * rng.normal(size=(poses, 2))
    model.poses.extend(t=x, th=0.1 * rng.normal(size=poses))
    a = [*range(poses - 1), 0]
    b = [*range(1, poses), poses - 1]
    moved = [[j - i + 0.01, 0.02] for i, j in zip(a, b, strict=True)]
    u = np.broadcast_to(np.diag([10.0, 10, 30]), (poses, 3, 3))
    model.edges.extend(a=a, b=b, t=moved, th=[0.01] * poses, u=u)
    model.anchors.append(pose=model.poses[0], t=[0, 0], th=0)
    return model


def _ceres(folder: Path) -> list[str]:
    export("pose_graph_3d", "ceres").write(folder)
    include = ["-I/usr/include/eigen3", f"-I{folder}"]
    _call("gcc", "-O2", "-c", "pose_graph_3d.c", folder=folder)
    _call(
        "g++", "-O2", "-std=c++17", *include, HERE / "autodiff.cpp", "pose_graph_3d.o", "-lceres",
        "-lglog", "-o", "main", folder=folder,
    )  # fmt: skip
    plain, exported, automatic = map(float, _call(folder / "main", folder=folder).split())
    return [
        "Residual and Jacobian of an edge of `pose_graph_3d`, medians of nine turns; the cost",
        "function also multiplies by the derivative of Minus, which Ceres divides out again.",
        "",
        *table(
            ("what", "ns", "Ceres' automatic differentiation takes"),
            [
                ("C function", f"{plain:.0f}", f"{automatic / plain:.1f} times"),
                (
                    "exported `CostFunction`",
                    f"{exported:.0f}",
                    f"{automatic / exported:.1f} times",
                ),
                ("automatic differentiation", f"{automatic:.0f}", ""),
            ],
        ),
    ]


def _window(folder: Path) -> list[str]:
    model = window()
    start = np.column_stack([model.poses.t.value, model.poses.th.value]).copy()
    project = export("pose_graph_2d", data=model, size="data")
    solve = _solver(project, folder)
    times: dict[str, list[float]] = {"exported C": [], "arael in Python's process": []}
    for _ in range(200):
        times["exported C"].append(solve(start))
        model.poses.t.value[:], model.poses.th.value[:] = start[:, :2], start[:, 2]
        began = time.perf_counter()
        model.solve()
        times["arael in Python's process"].append(time.perf_counter() - began)
    c, python = (median(found) for found in times.values())
    return [
        "A solve from the same start, 200 by turns, in one process.",
        "",
        *table(
            ("what", "microseconds", "ratio"),
            [
                ("exported C, `-O2`", f"{1e6 * c:.1f}", f"{c / python:.3f}"),
                ("arael in Python's process", f"{1e6 * python:.1f}", ""),
            ],
        ),
    ]


def _solver(project: Export, folder: Path) -> Any:
    """A function that solves from a start, by the program's own data; seconds."""
    project.write(folder)
    text = (folder / "main.c").read_text(encoding="utf-8")
    text = text[: text.index("int main(void)")].replace("#include <stdio.h>", "")
    (folder / "call.c").write_text(
        text
        + "void call(const double *start)\n{\n"
        + "    for (int k = 0; k < 10; k++)\n"
        + "        for (int i = 0; i < 3; i++) data.parameters.pose[k][i] = start[3 * k + i];\n"
        + "    const pose_graph_2d_options options = pose_graph_2d_default_options();\n"
        + "    pose_graph_2d_solve(&state, &data, &options);\n}\n",
        encoding="utf-8",
    )
    sources = ("call.c", "pose_graph_2d.c", "pose_graph_2d_solver.c")
    _call("gcc", "-O2", "-shared", "-fPIC", *sources, "-o", "call.so", "-lm", folder=folder)
    library = ctypes.CDLL(str(folder / "call.so"))

    def solve(start: Any) -> float:
        at = ctypes.c_void_p(start.ctypes.data)
        began = time.perf_counter()
        library.call(at)
        return time.perf_counter() - began

    return solve


def _board(folder: Path) -> list[str]:
    size = {"poses": 10, "edges": 20, "anchors": 1}
    project = export("pose_graph_2d", data=window(), size=size, precision="f32")
    project.write(folder)
    flags = BOARD.split()
    sources = ["pose_graph_2d.c", "pose_graph_2d_solver.c"]
    _call("arm-none-eabi-gcc", *flags, "-c", *sources, folder=folder)
    objects = [source.replace(".c", ".o") for source in sources]
    rows = _call("arm-none-eabi-size", *objects, folder=folder).splitlines()[1:]
    code = sum(int(row.split()[0]) + int(row.split()[1]) for row in rows)
    (folder / "sizes.c").write_text(
        '#include "pose_graph_2d_solver.h"\n'
        "char state[sizeof(pose_graph_2d_state)], data[sizeof(pose_graph_2d_data)];\n",
        encoding="utf-8",
    )
    _call("arm-none-eabi-gcc", *flags, "-c", "sizes.c", folder=folder)
    ram = int(_call("arm-none-eabi-size", "sizes.o", folder=folder).splitlines()[1].split()[2])
    link = ["-T", HERE / "board" / "memory.ld", "-nostartfiles", "--specs=rdimon.specs"]
    _call(
        "arm-none-eabi-gcc", *flags, "main.c", *sources, HERE / "board" / "startup.c", *link, "-lm",
        "-o", "board.elf", folder=folder,
    )  # fmt: skip
    semihosting = ["-nographic", "-semihosting-config", "enable=on,target=native"]
    board = _call(
        "qemu-system-arm", "-M", "mps2-an500", *semihosting, "-kernel", "board.elf", folder=folder
    )
    desktop = ["-O1", "-ffp-contract=off", "main.c", *sources, "-o", "desktop", "-lm"]
    _call("gcc", *desktop, folder=folder)
    same = board == _call(folder / "desktop", folder=folder)
    digits = "those" if same else "NOT those"
    return [
        f"`pose_graph_2d` in f32 for 10 poses, 20 edges and an anchor, `{BOARD}`:",
        f"{code / 1024:.1f} kB of code, {ram / 1024:.1f} kB of RAM for problem and workspace.",
        f"Under QEMU (mps2-an500) its digits are {digits} of the same program on this machine.",
    ]


def _call(*words: object, folder: Path) -> str:
    program = shutil.which(str(words[0]))
    if program is None:
        raise FileNotFoundError(2, "missing", str(words[0]))
    done = subprocess.run(
        [program, *map(str, words[1:])], cwd=folder, capture_output=True, text=True, timeout=600,
        check=False,
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, words[:3]))}: {done.stderr.strip()[-400:]}")
    return done.stdout

"""Calibration of an arm of seven joints from measured positions of a point on its tool.

    python arm_calibration.py [--shots 60] [--seed 1] [--plot arm_calibration.png] [--data FOLDER]

Not all Denavit-Hartenberg parameters can be found from positions. The model `arm_calibration.arael`
is diagnosed, then solved twice: with six parameters held, and with priors from the drawing.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael
from arael.geometry import quat_from_matrix, rotation_from_vector

Array = NDArray[np.float64]

MODEL = Path(__file__).with_name("arm_calibration.arael")
QUARTER = np.pi / 2
DRAWING = np.array([
    [0, 0.34, 0, -QUARTER],
    [0, 0.0, 0, QUARTER],
    [0, 0.4, 0, QUARTER],
    [0, 0.0, 0, -QUARTER],
    [0, 0.4, 0, -QUARTER],
    [0, 0.0, 0, QUARTER],
    [0, 0.126, 0, 0],
])  # fmt: skip
"""theta, d, a, alpha of each joint as drawn [rad, m, m, rad]."""
TOLERANCE = np.array([2e-3, 5e-4, 5e-4, 2e-3])
TOOL = np.array([0.06, 0.02, 0.1])
SIGMA = 1e-4
"""Noise of a measured position in each direction [m]."""
NAMES = ("theta", "d", "a", "alpha")
HELD = ((0, "theta"), (0, "d"), (6, "a"))
"""Joint and parameter that are held at the drawing, beside the three numbers of the tool."""


@dataclass(frozen=True)
class Arm:
    """Measurements, and the truth.

    Attributes
    ----------
    q, seen : encoders (n, 7) [rad], measured positions (n, 3) [m]
    links : true theta, d, a, alpha (7, 4)
    base : true translation (3,) and rotation vector (3,) of the arm in the instrument's frame
    """

    q: Array
    seen: Array
    links: Array
    base: tuple[Array, Array]


def forward(q: Array, links: Array, base: tuple[Array, Array], tool: Array = TOOL) -> Array:
    """Positions (n, 3) of the point on the tool, in the frame of the instrument [m]."""
    p = np.broadcast_to(tool, (len(q), 3))
    for k in reversed(range(7)):
        theta, d, a, alpha = links[k]
        p = p @ rotation_from_vector([alpha, 0, 0]).T + [a, 0, d]
        turn = rotation_from_vector(np.outer(q[:, k] + theta, [0, 0, 1]))
        p = np.einsum("nij,nj->ni", turn, p)
    return p @ rotation_from_vector(base[1]).T + base[0]


def simulate(shots: int = 60, seed: int = 1) -> Arm:
    """An arm within its tolerances, measured in random postures."""
    rng = np.random.default_rng(seed)
    links = DRAWING + TOLERANCE * rng.normal(size=(7, 4))
    for joint, name in HELD:  # what cannot be told from positions is as drawn
        links[joint, NAMES.index(name)] = DRAWING[joint, NAMES.index(name)]
    base = np.array([2.0, -0.5, 0.1]), np.array([0.02, -0.03, 2.0])
    q = rng.uniform(-1.8, 1.8, (shots, 7))
    seen = forward(q, links, base) + rng.normal(0, SIGMA, (shots, 3))
    return Arm(q, seen, links, base)


def problem(arm: Arm) -> Any:
    """The problem at its start, the drawing, with nothing held."""
    model: Any = arael.load(MODEL)(sigma=SIGMA, tool=TOOL)
    turn = quat_from_matrix(rotation_from_vector([0, 0, 2.0]))
    model.base = [2.0, -0.5, 0.0, *turn]  # set up roughly
    model.joints.extend(**dict(zip(NAMES, DRAWING.T, strict=True)))
    model.chain = list(range(7))
    model.shots.extend(q=arm.q, seen=arm.seen)
    return model


def held(arm: Arm) -> Any:
    """The problem with six parameters held, so that the others are determined."""
    model = problem(arm)
    model.tool.fixed = True
    for joint, name in HELD:
        getattr(model.joints[joint], name).fixed = True
    return model


def with_priors(arm: Arm) -> Any:
    """The problem with a prior from the drawing on each parameter of a joint; the tool is known."""
    model = problem(arm)
    model.tool.fixed = True
    for joint, row in zip(model.joints, DRAWING, strict=True):
        joint.drawing = dict(
            zip(NAMES, row, strict=True), angle_sigma=TOLERANCE[0], length_sigma=TOLERANCE[1]
        )
    return model


def links_of(model: Any) -> Array:
    """theta, d, a, alpha (7, 4) of a model."""
    return np.column_stack([getattr(model.joints, name).value for name in NAMES])


def prediction(model: Any, arm: Arm, seed: int = 100) -> float:
    """RMS error of predicted positions in 500 other postures [m]."""
    q = np.random.default_rng(seed).uniform(-1.8, 1.8, (500, 7))
    base = model.base.translation, arael.geometry.rotation_vector(model.base.rotation_matrix)
    off = forward(q, links_of(model), base) - forward(q, arm.links, arm.base)
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def report(name: str, model: Any, result: Any, arm: Arm) -> list[str]:
    """Lines on a solution."""
    off = np.abs(links_of(model) - arm.links)
    angle, length = off[:, [0, 3]].max(), off[:, [1, 2]].max()
    return [
        f"{name}: {result.status}, cost {result.start_cost:.0f} -> {result.end_cost:.1f}, "
        f"{len(model.parameter_names())} parameters, {3 * len(arm.q)} measured numbers",
        f"  largest error of the links {1e3 * angle:.2f} mrad, {1e3 * length:.2f} mm; "
        f"predicted positions {1e3 * prediction(model, arm):.3f} mm RMS",
    ]


def plot(arm: Arm, solved: dict[str, Any], path: Path) -> str:
    """Draw the errors of the links with their sigmas, and the residuals before and after."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    @styled
    def draw() -> Any:
        figure, (links, spread) = new_figure(11.0, 4.4, columns=2)
        for (name, model), color, shift in zip(
            solved.items(), (BLUE, ORANGE), (-0.15, 0.15), strict=True
        ):
            sigma = dict(zip(model.parameter_names(), model.covariance().sigma(), strict=True))
            off = 1e3 * (links_of(model) - arm.links).ravel()
            bars = [1e3 * sigma.get(f"joints[{k}].{part}", 0.0) for k in range(7) for part in NAMES]
            at = np.arange(28) + shift
            links.errorbar(at, off, bars, fmt=".", ms=4, lw=1, color=color, label=name)
        drawn = 1e3 * (DRAWING - arm.links).ravel()
        links.plot(np.arange(28), drawn, "_", color=GREY, label="drawing")
        links.set_xticks(np.arange(28) + 0.0, 7 * ["θ", "d", "a", "α"], fontsize=8)
        links.set(ylabel="error [mm, mrad]", title="links 1 to 7: found minus true, with sigma")
        links.legend(ncols=3)
        before = np.linalg.norm(problem(arm).residual_values("Shot.position").raw, axis=1)
        rows = [
            np.linalg.norm(m.residual_values("Shot.position").raw, axis=1) for m in solved.values()
        ]
        spread.semilogy(np.sort(1e3 * before), color=GREY, label="drawing")
        for name, row, color in zip(solved, rows, (BLUE, ORANGE), strict=True):
            spread.semilogy(np.sort(1e3 * row), color=color, label=name)
        spread.set(
            xlabel="shot, sorted", ylabel="distance [mm]", title="measured against predicted"
        )
        spread.legend()
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate measurements, diagnose, calibrate in two ways, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--shots", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problems here, for the command line")
    args = parser.parse_args(arguments)

    arm = simulate(args.shots, args.seed)
    models = {"free": problem(arm), "held": held(arm), "with priors": with_priors(arm)}
    if args.data:
        args.data.mkdir(parents=True, exist_ok=True)
        for name, model in models.items():
            model.write(args.data / f"arm_{name.replace(' ', '_')}.json")
    print(models.pop("free").free_directions())
    for name, model in models.items():
        print("\n".join(report(name, model, model.solve(rel_precision=1e-9), arm)))
    if args.plot:
        print("wrote", plot(arm, models, args.plot))


if __name__ == "__main__":
    main()

"""Time of the phases of an iteration on SLAM for several solvers, and their agreement.

    python bench_investigate.py [--poses 60] [--plot bench_investigate.png]

Splits an iteration into linearisation (residuals, derivatives, assembly of J'J) and the linear
system, for each solver, and checks each solution against the others: the costs and
the parameters.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from arael.demo.compare import SolverRun, disagreement, solve_with, table
from arael.scenes import benchmark_config, make_scene

MODEL = Path(__file__).with_name("slam.arael")
SOLVERS = ("dense", "sparse", "schur")


def run(poses: int, repeats: int = 3) -> list[SolverRun]:
    """Solve one scene with each solver."""
    scene = make_scene(benchmark_config(poses))
    return [solve_with("slam", str(MODEL), scene, solver, repeats=repeats) for solver in SOLVERS]


def pairs(runs: Sequence[SolverRun]) -> list[tuple[str, str, float, float]]:
    """Of each pair of solvers: largest difference of a parameter, and of the costs, relative."""
    return [
        (a.solver, b.solver, float(np.abs(a.x - b.x).max()), abs(a.cost - b.cost) / a.cost)
        for i, a in enumerate(runs)
        for b in runs[i + 1 :]
    ]


def plot(runs: Sequence[SolverRun], path: Path) -> str:
    """Draw the phases of an iteration for each solver."""
    from arael.plot.figure import save
    from arael.plot.timings import phases_figure

    phases = [
        ("linearise", [one.linearise for one in runs]),
        ("factorise and solve", [one.linear for one in runs]),
    ]
    title = f"SLAM with {runs[0].poses} poses, {runs[0].parameters} unknowns"
    return save(phases_figure([one.solver for one in runs], phases, title), path)


def main() -> None:
    """Print the table of phases and the cross-check."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    runs = run(args.poses)
    print("\n".join(table(runs, "sparse")))
    for a, b, apart, costs in pairs(runs):
        print(f"{a} and {b}: parameters within {apart:.1e}, costs within {costs:.1e}")
    print(f"all agree to {disagreement(runs):.1e}")
    if args.plot:
        print("wrote", plot(runs, args.plot))


if __name__ == "__main__":
    main()

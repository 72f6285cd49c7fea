"""Band and dense Cholesky on localisation, for increasing numbers of poses.

    python bench_band.py [--poses 50 100 200 500] [--plot bench_band.png]

The model is `localization.arael` in this folder: with a known map no constraint couples more than
two consecutive poses, so the Hessian is block-tridiagonal.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from arael.demo.compare import SolverRun, disagreement, solve_with, table
from arael.scenes import benchmark_config, make_scene

MODEL = Path(__file__).with_name("localization.arael")
SOLVERS = ("dense", "band")


def run(poses: Sequence[int], repeats: int = 3) -> list[SolverRun]:
    """Solve a scene of each size with each solver."""
    found = []
    for count in poses:
        scene = make_scene(benchmark_config(count))
        found += [
            solve_with("localization", str(MODEL), scene, solver, repeats=repeats)
            for solver in SOLVERS
        ]
    return found


def plot(runs: Sequence[SolverRun], path: Path) -> str:
    """Draw the time of the linear system against the number of poses."""
    from arael.plot.figure import save
    from arael.plot.timings import growth_figure

    lines = [
        (name, *zip(*[(r.poses, r.linear) for r in runs if r.solver == name], strict=True))
        for name in SOLVERS
    ]
    return save(growth_figure(lines, "localisation: factorise and solve", "poses"), path)


def main() -> None:
    """Print the table, and how well the solvers agree."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, nargs="+", default=[50, 100, 200, 500])
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    runs = run(args.poses)
    print("\n".join(table(runs, "dense")))
    for count in args.poses:
        apart = disagreement([one for one in runs if one.poses == count])
        print(f"{count} poses: solutions agree to {apart:.1e}")
    if args.plot:
        print("wrote", plot(runs, args.plot))


if __name__ == "__main__":
    main()

"""Localization in a known map, with half of the data associations wrong.

    python loc_demo.py [--poses 60] [--seed 42] [--trajectory s-curve|loop|eight] [--plot loc.png]

The model is `localization.arael` in this folder: SLAM with the landmarks as data. No constraint
couples more than two consecutive poses, so the Hessian is block-tridiagonal and the band solver
takes time proportional to the number of poses. The command `arael demo localization` does the same.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from arael.demo.localization import plot, report, run_localization
from arael.demo.scene_run import SolveOptions
from arael.scenes import TRAJECTORIES, demo_config


def main() -> None:
    """Generate a scene, solve it with the band solver, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--trajectory", choices=TRAJECTORIES, default="s-curve")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    scene = demo_config(args.poses, trajectory=args.trajectory, seed=args.seed)
    model = Path(__file__).with_name("localization.arael")
    run = run_localization(scene, SolveOptions(model=str(model), solver="band", verbose=True))

    print("\n".join(report(run)))
    if args.plot:
        print("wrote", ", ".join(plot(run, args.plot)))


if __name__ == "__main__":
    main()

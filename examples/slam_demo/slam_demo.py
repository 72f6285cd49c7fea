"""Visual-inertial SLAM with half of the data associations wrong.

    python slam_demo.py [--poses 60] [--seed 42] [--trajectory s-curve|loop|eight] [--plot slam.png]

The model is `slam.arael` in this folder. The command `arael demo slam` does the same.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from arael.demo.scene_run import SolveOptions
from arael.demo.slam import plot, report, run_slam
from arael.scenes import TRAJECTORIES, demo_config


def main() -> None:
    """Generate a scene, solve it, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--poses", type=int, default=60)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--trajectory", choices=TRAJECTORIES, default="s-curve")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    scene = demo_config(args.poses, trajectory=args.trajectory, seed=args.seed)
    model = Path(__file__).with_name("slam.arael")
    run = run_slam(scene, SolveOptions(model=str(model), verbose=True))

    print("\n".join(report(run)))
    if args.plot:
        print("wrote", ", ".join(plot(run, args.plot)))


if __name__ == "__main__":
    main()

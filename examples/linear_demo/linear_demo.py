"""A line fit with outliers: least squares and robust fit.

    python linear_demo.py [--points 100] [--seed 42] [--plot linear.png]

The model is `linear.arael` in this folder. The command `arael demo linear` does the same.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from arael.demo.linear import plot, report, run_linear
from arael.demo.scene_run import SolveOptions


def main() -> None:
    """Generate points, fit them twice, compare with the true line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--points", type=int, default=100)
    parser.add_argument("--seed", type=int, default=42)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()

    model = Path(__file__).with_name("linear.arael")
    run = run_linear(args.points, seed=args.seed, options=SolveOptions(model=str(model)))

    print("\n".join(report(run)))
    if args.plot:
        print("wrote", ", ".join(plot(run, args.plot)))


if __name__ == "__main__":
    main()

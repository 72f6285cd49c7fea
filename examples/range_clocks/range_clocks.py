"""Ranges by a clock of their own: its offset and skew, the beacons, the path as a spline.

    python range_clocks.py [--seed 1] [--plot range_clocks.png] [--data FOLDER]

Positions come at 4 Hz. The radio measures a range when a beacon happens to answer.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import arael

Array = NDArray[np.float64]

HERE = Path(__file__).parent
FIX_SIGMA, RANGE_SIGMA = 0.02, 0.05
"""Noise of a coordinate and of a range [m]."""
STEP, FIX_STEP = 0.5, 0.25
"""Time between control points and between positions [s]."""
SPAN = 1.0
"""Largest offset that is considered, either way [s]."""


@dataclass(frozen=True)
class Drive:
    """Measurements, and the truth.

    Attributes
    ----------
    t, pos : positions, (n,) by their clock and (n, 2)
    times, beacon, ranges : (m,) by the clock of the radio, index of the beacon, metres
    truth : offset, skew, delay, coordinates of beacons (3 + 2 k)
    """

    t: Array
    pos: Array
    times: Array
    beacon: NDArray[np.int64]
    ranges: Array
    truth: Array

    @property
    def middle(self) -> float:
        """Time at which the offset is meant."""
        return float(self.times.mean())


def simulate(seed: int = 1, offset: float = 0.3172, skew: float = 120e-6) -> Drive:
    """Two minutes of loops between four beacons, ten ranges a second on average."""
    rng = np.random.default_rng(seed)
    seconds, delay = 120.0, 0.236
    beacons = np.array([[-15.0, -11.0], [16.0, -13.0], [14.0, 12.0], [-17.0, 9.0]])
    phase = rng.uniform(0, 2 * np.pi, 4)

    def at(t: Array) -> Array:
        x = 9 * np.sin(0.23 * t + phase[0]) + 2.5 * np.sin(0.71 * t + phase[1])
        y = 7 * np.sin(0.31 * t + phase[2]) + 2.5 * np.sin(0.83 * t + phase[3])
        return np.stack([x, y], axis=1)

    t = np.arange(0.0, seconds + FIX_STEP / 2, FIX_STEP)
    pos = at(t) + FIX_SIGMA * rng.normal(size=(len(t), 2))
    moments = np.sort(rng.uniform(1.5, seconds - 2.0, int(10 * (seconds - 3.5))))
    beacon = rng.integers(len(beacons), size=len(moments))
    ranges = np.linalg.norm(beacons[beacon] - at(moments), axis=1) + delay
    ranges += RANGE_SIGMA * rng.normal(size=len(moments))
    # With `m` the mean of `times`: moments = times + offset + skew * (times - m).
    mean = moments.mean() - offset
    times = mean + (moments - moments.mean()) / (1 + skew)
    truth = np.array([offset, skew, delay, *beacons.ravel()])
    return Drive(t, pos, times, beacon, ranges, truth)


def multilaterate(drive: Drive, offset: float) -> tuple[float, float, Array]:
    """Beacons for a known offset: mean squared error, delay and places (k, 2).

    With the place `p` of the radio, `b` of the beacon, the range `r` and the delay `c`:
    ``r^2 - |p|^2 = 2 c r - 2 p.b + (|b|^2 - c^2)``. Least squares in `b`, `c` and one number more
    for each beacon; the error of a square is 2 r times that of the range.
    """
    t = drive.times + offset
    place = np.stack([np.interp(t, drive.t, column) for column in drive.pos.T], axis=1)
    count = drive.beacon.max() + 1
    mine = drive.beacon[:, None] == np.arange(count)
    columns = np.concatenate([
        2 * drive.ranges[:, None], *(-2 * mine * x[:, None] for x in place.T), mine
    ], axis=1)  # fmt: skip
    weight = 1 / (2 * drive.ranges)
    squares = drive.ranges**2 - (place**2).sum(axis=1)
    found, *_ = np.linalg.lstsq(weight[:, None] * columns, weight * squares, rcond=None)
    error = weight * (columns @ found - squares)
    return float(np.mean(error**2)), float(found[0]), found[1 : 1 + 2 * count].reshape(2, -1).T


def start(drive: Drive) -> Array:
    """Offset, skew, delay and coordinates of beacons (3 + 2 k) without a guess.

    The offset is that at which places for the beacons agree best with the ranges.
    """
    offsets = np.arange(-SPAN, SPAN, FIX_STEP / 5)
    offset = offsets[np.argmin([multilaterate(drive, offset)[0] for offset in offsets])]
    _, delay, beacons = multilaterate(drive, offset)
    return np.array([offset, 0.0, delay, *beacons.ravel()])


def knot_times(drive: Drive) -> Array:
    """Times of the control points, one of them before the first position, one behind the last."""
    return drive.t[0] + STEP * np.arange(-1, np.ceil((drive.t[-1] - drive.t[0]) / STEP) + 2)


def problem(drive: Drive, first: Array | None = None) -> Any:
    """The problem at a start, by default that of `start`."""
    first = start(drive) if first is None else first
    model: Any = arael.load(HERE / "range_clocks.arael")(
        fix_sigma=FIX_SIGMA, range_sigma=RANGE_SIGMA, middle=drive.middle,
        offset=first[0], skew=first[1], delay=first[2],
    )  # fmt: skip
    t = knot_times(drive)
    model.knots.extend(
        t=t, pos=np.stack([np.interp(t, drive.t, column) for column in drive.pos.T], axis=1)
    )
    model.beacons.extend(pos=first[3:].reshape(-1, 2))
    model.fixes.extend(t=drive.t, pos=drive.pos)
    model.ranges.extend(time=drive.times, beacon=drive.beacon, range=drive.ranges)
    return model


def solution(model: Any) -> Array:
    """Offset, skew, delay and coordinates of beacons of a model (3 + 2 k)."""
    one = (model.offset, model.skew, model.delay)
    return np.array([*(float(x.value) for x in one), *model.beacons.pos.value.ravel()])


def covariance(model: Any) -> Array:
    """Their covariance (3 + 2 k, 3 + 2 k)."""
    found: Array = model.covariance().marginal(["offset", "skew", "delay", *model.beacons])
    return found


def report(model: Any, result: Any, drive: Drive) -> list[str]:
    """Lines on a solution."""
    residuals, variables = model.jacobian().shape
    found, sigma = solution(model), np.sqrt(np.diag(covariance(model)))
    off = np.abs(found - drive.truth)
    lines = [
        f"{len(drive.ranges)} ranges to {len(model.beacons)} beacons, {len(drive.t)} positions, "
        f"{len(model.knots)} control points",
        f"start: offset {1e3 * start(drive)[0]:.0f} ms",
        f"{result.status}: cost {result.end_cost:.1f} of {residuals - variables} degrees of "
        "freedom",
    ]
    for name, k, factor, unit in (
        ("offset", 0, 1e3, "ms"), ("skew", 1, 1e6, "ppm"), ("delay", 2, 1e3, "mm")
    ):  # fmt: skip
        lines.append(
            f"  {name:8} {factor * found[k]:9.2f} {unit:4}"
            f"  error {factor * off[k]:6.2f}  sigma {factor * sigma[k]:6.2f}"
        )
    away, spread = (
        1e3 * np.sqrt(np.mean(np.sum(v[3:].reshape(-1, 2) ** 2, axis=1))) for v in (off, sigma)
    )
    lines.append(f"  beacons  {'':9} mm    error {away:6.2f}  sigma {spread:6.2f}  (RMS)")
    return lines


def plot(drive: Drive, model: Any, path: Path) -> str:
    """Draw path and beacons, and the errors of ranges at the times of their clock and of ours."""
    from scipy.interpolate import BSpline

    from arael.plot.figure import BLUE, GREY, INK, ORANGE, new_figure, save, styled

    knots = knot_times(drive)
    spline = BSpline(knots[0] + STEP * (np.arange(len(knots) + 4) - 2), model.knots.pos.value, 3)
    offset, skew, delay = solution(model)[:3]
    beacons = model.beacons.pos.value

    def errors(t: Array) -> Array:
        seen: Array = np.linalg.norm(beacons[drive.beacon] - spline(t), axis=1)
        return drive.ranges - delay - seen

    ours = drive.times + offset + skew * (drive.times - drive.middle)

    @styled
    def draw() -> Any:
        figure, (way, time) = new_figure(10.0, 4.2, columns=2)
        way.plot(*drive.pos.T, ".", color=GREY, ms=3, label="positions")
        way.plot(*spline(np.linspace(drive.t[0], drive.t[-1], 2000)).T, color=BLUE, lw=1)
        way.plot(*beacons.T, "^", color=INK, ms=7, label="beacons")
        way.set(xlabel="x [m]", ylabel="y [m]", ylim=(-15, 17), title="path and beacons")
        way.set_aspect("equal")
        way.legend(loc="upper center", ncols=2, fontsize=8)
        for t, color, label in (
            (drive.times, ORANGE, "at the time of its clock"),
            (ours, BLUE, "with offset and skew"),
        ):
            time.plot(ours, errors(t), ".", color=color, ms=3, label=label)
        time.set(xlabel="time [s]", ylabel="m", ylim=(-2, 2.4), title="error of ranges")
        time.legend(loc="upper right", fontsize=8)
        return figure

    return save(draw(), path)


def main(arguments: list[str] | None = None) -> None:
    """Simulate a drive, solve, compare with the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--plot", type=Path)
    parser.add_argument("--data", type=Path, help="write the problem here, for `arael solve`")
    args = parser.parse_args(arguments)

    drive = simulate(seed=args.seed)
    model = problem(drive)
    if args.data:
        args.data.mkdir(parents=True, exist_ok=True)
        model.write(args.data / "range_clocks.json")
    print("\n".join(report(model, model.solve(), drive)))
    if args.plot:
        print("wrote", plot(drive, model, args.plot))


if __name__ == "__main__":
    main()

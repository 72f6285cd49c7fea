"""Many small robust fits in one call, beside a loop over SciPy's `least_squares`.

Lines ``y = a x + b`` through ten samples each, one in ten of them far off, residuals capped by
``gamma atan(r / gamma)`` in both systems, which also start alike. SciPy calls Python functions
(residuals and Jacobian, vectorised over the samples of a fit): it has no compiled way.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import child, table
from benchmarks.systems import Plan

Array = NDArray[np.float64]

MODEL = """
struct Sample {
    x: real
    y: real

    constraint line {
        starship((parent.a * x + parent.b - y) * root.isigma, root.gamma)
    }
}

struct Fit {
    param a: real
    param b: real
    samples: list of Sample
}

root Fits {
    fits: list of Fit
    isigma: real = 50
    gamma: real = 3
}
"""
SAMPLES = 10
ISIGMA, GAMMA = 50.0, 3.0
COUNT, QUICK_COUNT = 100_000, 2_000
BESIDE = 200
"""Fits that SciPy solves."""


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure both, each in a process of its own; return the report's lines."""
    count = QUICK_COUNT if plan.quick else COUNT
    rows = []
    scipy = child("fit", "scipy", count)
    for threads in plan.threads:
        ours = child("fit", "arael", count, threads, threads=threads)
        gap = max(abs(a - b) for a, b in zip(ours["cost"], scipy["cost"], strict=True))
        rows.append(
            (
                f"arael, {threads} t",
                count,
                f"{ours['seconds']:.3f}",
                f"{1e6 * ours['seconds'] / count:.2f}",
                ours["iterations"],
                f"{sum(ours['cost']):.6f}",
                f"{scipy['seconds'] / BESIDE / (ours['seconds'] / count):.0f}",
                f"{gap:.1e}",
            )
        )
    rows.append(
        (
            f"SciPy {scipy['version']}",
            BESIDE,
            f"{scipy['seconds']:.3f}",
            f"{1e6 * scipy['seconds'] / BESIDE:.0f}",
            scipy["iterations"],
            f"{sum(scipy['cost']):.6f}",
            "",
            "",
        )
    )
    return [
        "## fit",
        "",
        f"{count} independent fits of ``a x + b`` to {SAMPLES} samples, robust, in one call of "
        f"`solve`, beside a loop over `scipy.optimize.least_squares` (trust region, analytic "
        f"Jacobian) for the first {BESIDE}. Seconds are those of the call, structure and "
        f"compilation known. The cost is that of the first {BESIDE} fits, of both by the same "
        f"formula; the gap is the largest between two costs of one fit.",
        "",
        *table(
            ("system", "fits", "seconds", "us a fit", "iterations", "cost", "SciPy / arael", "gap"),
            rows,
        ),
    ]


def data(count: int) -> tuple[Array, Array, Array]:
    """Abscissae and ordinates (count, samples), and starts (count, 2)."""
    rng = np.random.default_rng(42)
    truth = rng.uniform(-1, 1, (count, 2))
    x = np.tile(np.linspace(-1, 1, SAMPLES), (count, 1))
    y = truth[:, :1] * x + truth[:, 1:] + rng.normal(0, 1 / ISIGMA, x.shape)
    y += (rng.random(x.shape) < 0.1) * rng.normal(0, 0.5, x.shape)
    return x, y, truth + rng.normal(0, 0.02, truth.shape)


def capped(ab: Array, x: Array, y: Array) -> Array:
    """Residuals of one fit, or of many."""
    plain = (ab[..., :1] * x + ab[..., 1:] - y) * ISIGMA
    return np.asarray(GAMMA * np.arctan(plain / GAMMA))


def fit_arael(count: int, threads: int) -> dict[str, object]:
    """All fits as one model, solved once to build what is kept, then again from the start."""
    import arael
    from arael.scenes import fill

    x, y, start = data(count)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fits.arael"
        path.write_text(MODEL, encoding="utf-8")
        model = arael.load(path)
        instance = model()
        columns = {
            "fits.a": start[:, 0],
            "fits.b": start[:, 1],
            "fits.samples.offsets": np.arange(0, SAMPLES * count + 1, SAMPLES),
            "fits.samples.x": x.ravel(),
            "fits.samples.y": y.ravel(),
        }
        fill(instance, model.layout, columns)
        seconds = 0.0
        for _ in range(2):
            instance.fits.a.value[:], instance.fits.b.value[:] = start.T
            began = time.perf_counter()
            result = instance.solve(rel_precision=1e-9, num_threads=threads)
            seconds = time.perf_counter() - began
        found = np.column_stack([instance.fits.a.value, instance.fits.b.value])[:BESIDE]
    cost = (capped(found, x[:BESIDE], y[:BESIDE]) ** 2).sum(axis=1)
    return {"seconds": seconds, "iterations": int(result.iterations), "cost": cost.tolist()}


def fit_scipy(count: int) -> dict[str, object]:
    """The first fits, one after the other."""
    import scipy
    from scipy.optimize import least_squares

    def jacobian(ab: Array, x: Array, y: Array) -> Array:
        plain = (ab[0] * x + ab[1] - y) * ISIGMA
        slope = ISIGMA / (1 + (plain / GAMMA) ** 2)
        return np.column_stack([slope * x, slope])

    x, y, start = data(count)
    cost, steps = [], 0
    began = time.perf_counter()
    for k in range(BESIDE):
        found = least_squares(capped, start[k], jacobian, args=(x[k], y[k]), ftol=1e-9, xtol=1e-9)
        cost.append(2 * float(found.cost))
        steps += found.nfev
    seconds = time.perf_counter() - began
    version = scipy.__version__
    steps = round(steps / BESIDE)
    return {"seconds": seconds, "iterations": steps, "cost": cost, "version": version}


if __name__ == "__main__":
    if sys.argv[1] == "arael":
        print(json.dumps(fit_arael(int(sys.argv[2]), int(sys.argv[3]))))
    else:
        print(json.dumps(fit_scipy(int(sys.argv[2]))))

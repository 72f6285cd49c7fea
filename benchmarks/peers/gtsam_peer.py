"""GTSAM: Levenberg-Marquardt as Ceres has it, multifrontal Cholesky in a METIS ordering.

To the end (`benchmarks.peers.endings`) with its default tolerances: this and Levenberg-Marquardt by
its own defaults, Gauss-Newton, dogleg, and for pose graphs the first and the third from chordal
initialisation (`InitializePose3`, in the plane `lago`). The first pose of a graph is held by the
prior that GTSAM's examples have, with variances of 1e-6 and 1e-4.

Rotations of pose graphs are weighed by the rotation vector, in the limit of small errors the same
as the model's. Scenes have GTSAM's reprojection factor with a body-to-sensor transform in the place
of the angular residuals, an attitude factor for the tilt, and no damping towards the start. There
is no compiled reprojection factor of a known point: in localization landmarks are variables, held
by priors of a micrometre. Maps of planes have GTSAM's oriented-plane factor, whose three residuals
compare normals in the tangent plane where the model compares their components.
"""

from __future__ import annotations

import ctypes
import os
import sys
import tempfile
from functools import partial
from typing import Any

import gtsam
import numpy as np

from benchmarks.peers.endings import Path
from benchmarks.peers.runner import main

HELD = 1e-6
"""Standard deviation of the priors on landmarks that are known [m]."""

FOCAL = 512 / np.tan(np.deg2rad(40))


class Gtsam:
    """A factor graph with a start."""

    settings = "LM (Ceres defaults), multifrontal Cholesky, METIS"

    def __init__(self, graph: gtsam.NonlinearFactorGraph, initial: gtsam.Values) -> None:
        self.graph, self.initial = graph, initial
        self.optimizer = None
        self.tried: dict[str, list[int]] = {}

    def start(self) -> None:
        parameters = _metis(gtsam.LevenbergMarquardtParams.CeresDefaults())
        self.optimizer = gtsam.LevenbergMarquardtOptimizer(self.graph, self.initial, parameters)

    def iterate(self, count: int, to_end: bool) -> int:
        before = self.optimizer.error()
        for k in range(count):
            self.optimizer.iterate()
            if to_end:
                after = self.optimizer.error()
                if before - after <= 1e-9 * before:
                    return k + 1
                before = after
        return count

    def ways(self) -> dict[str, str]:
        return {
            "LM": "LevenbergMarquardtParams, METIS",
            "LM (Ceres)": "LevenbergMarquardtParams.CeresDefaults, METIS",
            "GN": "GaussNewtonParams, METIS",
            "dogleg": "DoglegParams, METIS",
        }

    def fresh(self) -> None:
        self.optimizer = None

    def initial_of(self, way: str) -> gtsam.Values:
        """Where a way starts."""
        return self.initial

    def solve(self, way: str, path: Path, limit: int) -> str:
        kind, made = OPTIMIZERS[way.removeprefix("chordal + ")]
        parameters = _metis(made())
        parameters.setMaxIterations(limit)
        initial = self.initial_of(way)
        marking = kind is gtsam.LevenbergMarquardtOptimizer and way not in self.tried
        with _Tries(parameters if marking else None) as tries:
            parameters.iterationHook = lambda k, before, after: path.mark(after, k)
            self.optimizer = kind(self.graph, initial, parameters)
            path.mark(self.optimizer.error(), 0)
            self.optimizer.optimize()
        if marking:
            self.tried[way] = tries.counts(len(path.costs) - 1)
        path.counts = self.tried.get(way, path.counts)
        return "ended" if self.optimizer.iterations() < limit else "limit of iterations"


class _Tries:
    """Counts attempts at a step by the table that Levenberg-Marquardt prints, a line for each.

    An iteration of GTSAM's goes on until a step is accepted, and the wheel does not say how many it
    took. Without parameters nothing is printed.
    """

    def __init__(self, parameters: Any) -> None:
        self.parameters = parameters

    def __enter__(self) -> _Tries:
        if self.parameters is not None:
            self.parameters.setVerbosityLM("SUMMARY")
            self.file = tempfile.TemporaryFile("w+")
            sys.stdout.flush()
            self.before = os.dup(1)
            os.dup2(self.file.fileno(), 1)
        return self

    def __exit__(self, *error: object) -> None:
        if self.parameters is not None:
            ctypes.CDLL(None).fflush(None)
            os.dup2(self.before, 1)
            os.close(self.before)

    def counts(self, iterations: int) -> list[int]:
        """Attempts at the start and after each iteration, the number that rows begin with."""
        found = np.zeros(iterations, dtype=int)
        self.file.seek(0)
        for line in self.file:
            number = line.split(maxsplit=1)[0] if line.strip() else ""
            if number.isdigit() and int(number) < iterations:
                found[int(number)] += 1
        return [0, *(int(n) for n in np.cumsum(found))]


def _metis(parameters: Any) -> Any:
    parameters.setLinearSolverType("MULTIFRONTAL_CHOLESKY")
    parameters.setOrderingType("METIS")
    return parameters


OPTIMIZERS = {
    "LM": (gtsam.LevenbergMarquardtOptimizer, gtsam.LevenbergMarquardtParams),
    "LM (Ceres)": (
        gtsam.LevenbergMarquardtOptimizer,
        gtsam.LevenbergMarquardtParams.CeresDefaults,
    ),
    "GN": (gtsam.GaussNewtonOptimizer, gtsam.GaussNewtonParams),
    "dogleg": (gtsam.DoglegOptimizer, gtsam.DoglegParams),
}


class PoseGraph(Gtsam):
    """A g2o file; the first pose is held by a prior."""

    def __init__(self, path: str, threads: int) -> None:
        with open(path, encoding="utf-8") as file:
            self.spatial = "SE3" in file.readline()
        graph, initial = gtsam.readG2o(path, self.spatial)
        first = min(initial.keys())
        with open(path, encoding="utf-8") as file:
            for line in file:
                if line.startswith("VERTEX"):
                    first = int(line.split()[1])
                    break
        if self.spatial:
            held = gtsam.noiseModel.Diagonal.Variances(np.array([1e-6] * 3 + [1e-4] * 3))
            prior = gtsam.PriorFactorPose3(first, initial.atPose3(first), held)
        else:
            held = gtsam.noiseModel.Diagonal.Variances(np.array([1e-6, 1e-6, 1e-8]))
            prior = gtsam.PriorFactorPose2(first, initial.atPose2(first), held)
        graph.push_back(prior)
        super().__init__(graph, initial)

    def ways(self) -> dict[str, str]:
        start = "InitializePose3.initialize" if self.spatial else "lago.initialize"
        own = super().ways()
        return own | {f"chordal + {name}": f"{start}, {own[name]}" for name in ("LM", "GN")}

    def initial_of(self, way: str) -> gtsam.Values:
        if not way.startswith("chordal"):
            return self.initial
        if self.spatial:
            return gtsam.InitializePose3.initialize(self.graph)
        return gtsam.lago.initialize(self.graph)

    def answer(self) -> dict[str, np.ndarray]:
        values = self.optimizer.values()
        keys = sorted(values.keys())
        if not self.spatial:
            poses = [values.atPose2(k) for k in keys]
            t = np.array([[p.x(), p.y()] for p in poses])
            return {"id": np.array(keys), "t": t, "th": np.array([p.theta() for p in poses])}
        poses = [values.atPose3(k) for k in keys]
        q = np.array([p.rotation().toQuaternion().coeffs() for p in poses])[:, [3, 0, 1, 2]]
        t = np.array([p.translation() for p in poses])
        return {"id": np.array(keys), "t": t, "q": q}


class Bundle(Gtsam):
    """A BAL file, with GTSAM's camera of f, k1 and k2."""

    def __init__(self, path: str, threads: int) -> None:
        self.data = gtsam.SfmData.FromBalFile(path)
        graph = gtsam.NonlinearFactorGraph()
        noise = gtsam.noiseModel.Unit.Create(2)
        for j in range(self.data.numberTracks()):
            track = self.data.track(j)
            for k in range(track.numberMeasurements()):
                i, pixel = track.measurement(k)
                graph.add(gtsam.GeneralSFMFactorCal3Bundler(pixel, noise, i, gtsam.symbol("p", j)))
        initial = gtsam.Values()
        for i in range(self.data.numberCameras()):
            initial.insert(i, self.data.camera(i))
        for j in range(self.data.numberTracks()):
            initial.insert(gtsam.symbol("p", j), self.data.track(j).point3())
        super().__init__(graph, initial)

    def answer(self) -> dict[str, np.ndarray]:
        values, found = self.optimizer.values(), {k: [] for k in ("r", "t", "f", "k1", "k2")}
        # GTSAM's cameras look along +z, with y down: BAL's turned by pi about x.
        turn = np.diag([1.0, -1.0, -1.0])
        for i in range(self.data.numberCameras()):
            camera = values.atPinholeCameraCal3Bundler(i)
            rotation = turn @ camera.pose().rotation().matrix().T
            found["r"].append(gtsam.Rot3.Logmap(gtsam.Rot3(rotation)))
            found["t"].append(-rotation @ camera.pose().translation())
            calibration = camera.calibration()
            for name, value in zip(
                ("f", "k1", "k2"),
                (calibration.fx(), calibration.k1(), calibration.k2()),
                strict=True,
            ):
                found[name].append(value)
        points = [values.atPoint3(gtsam.symbol("p", j)) for j in range(self.data.numberTracks())]
        return {**{k: np.array(v) for k, v in found.items()}, "pos": np.array(points)}


class Slam(Gtsam):
    """A scene; `known` landmarks make it a localisation."""

    residuals = "of scenes: pixels instead of angles"

    def __init__(self, path: str, threads: int, known: bool = False) -> None:
        if known:
            self.residuals += "; known landmarks are variables held by priors"
        data = dict(np.load(path))
        self.poses, self.landmarks, self.known = len(data["pos"]), len(data["landmarks"]), known
        graph, initial = gtsam.NonlinearFactorGraph(), gtsam.Values()
        for k in range(self.poses):
            initial.insert(k, _pose(data["ea"][k], data["pos"][k]))
        points = data["true_landmarks" if known else "landmarks"]
        for j, point in enumerate(points):
            initial.insert(gtsam.symbol("l", j), point)
            if known:
                held = gtsam.noiseModel.Isotropic.Sigma(3, HELD)
                graph.add(gtsam.PriorFactorPoint3(gtsam.symbol("l", j), point, held))
        self._bearings(graph, data)
        self._motion(graph, data)
        super().__init__(graph, initial)

    def _bearings(self, graph: gtsam.NonlinearFactorGraph, data: dict[str, np.ndarray]) -> None:
        calibration = gtsam.Cal3_S2(FOCAL, FOCAL, 0.0, 512.0, 384.0)
        noise = gtsam.noiseModel.Unit.Create(2)
        sensors = [
            gtsam.Pose3(gtsam.Rot3(axes), pos)
            for axes, pos in zip(data["camera_axes"], data["camera_pos"], strict=True)
        ]
        for i, j, c, pixel in zip(
            data["obs_pose"], data["obs_landmark"], data["obs_camera"], data["obs_pixel"],
            strict=True,
        ):  # fmt: skip
            key = gtsam.symbol("l", int(j))
            graph.add(
                gtsam.GenericProjectionFactorCal3_S2(
                    pixel, noise, int(i), key, calibration, sensors[c]
                )
            )

    def _motion(self, graph: gtsam.NonlinearFactorGraph, data: dict[str, np.ndarray]) -> None:
        for k in range(1, self.poses):
            sigmas = np.concatenate([data["delta_ea_sigma"][k], data["delta_pos_sigma"][k]])
            motion = _pose(data["delta_ea"][k], data["delta_pos"][k])
            noise = gtsam.noiseModel.Diagonal.Sigmas(sigmas)
            graph.add(gtsam.BetweenFactorPose3(k - 1, k, motion, noise))
        tilt = gtsam.noiseModel.Isotropic.Sigma(2, np.deg2rad(0.25))
        gps = gtsam.noiseModel.Isotropic.Sigma(3, 2.5)
        for k in range(self.poses):
            roll, pitch = data["tilt"][k]
            up = gtsam.Rot3.Ypr(0.0, pitch, roll).matrix().T @ [0.0, 0.0, 1.0]
            graph.add(
                gtsam.AttitudeFactorPose3(
                    k, gtsam.Unit3(np.array([0.0, 0.0, 1.0])), tilt, gtsam.Unit3(up)
                )
            )
            if not self.known:
                graph.add(gtsam.GPSFactor(k, data["gps"][k], gps))

    def answer(self) -> dict[str, np.ndarray]:
        values = self.optimizer.values()
        poses = [values.atPose3(k) for k in range(self.poses)]
        return {
            "pos": np.array([p.translation() for p in poses]),
            "rotation": np.array([p.rotation().matrix() for p in poses]),
            "landmarks": np.array(
                [values.atPoint3(gtsam.symbol("l", j)) for j in range(self.landmarks)]
            ),
        }


class Plane(Gtsam):
    """A map of planes."""

    residuals = "of planes: normals compared in the tangent plane"

    def __init__(self, path: str, threads: int) -> None:
        data = dict(np.load(path))
        self.poses, self.planes = len(data["poses.pos"]), len(data["planes.c"])
        graph, initial = gtsam.NonlinearFactorGraph(), gtsam.Values()
        for k in range(self.poses):
            initial.insert(k, _pose(data["poses.ea"][k], data["poses.pos"][k]))
        for j in range(self.planes):
            plane = gtsam.OrientedPlane3(*data["planes.n"][j], data["planes.c"][j])
            initial.insert(gtsam.symbol("p", j), plane)
        angle = np.deg2rad(0.5)
        seen = gtsam.noiseModel.Diagonal.Sigmas(np.array([angle, angle, 0.02]))
        for i, j, n, c in zip(
            data["observations.pose"], data["observations.plane"],
            data["observations.n"], data["observations.c"], strict=True,
        ):  # fmt: skip
            z = np.append(n, c)
            key = gtsam.symbol("p", int(j))
            graph.add(gtsam.OrientedPlane3Factor(z, seen, int(i), key))
        moved = gtsam.noiseModel.Diagonal.Sigmas(np.array([angle] * 3 + [0.05] * 3))
        for i, j, turn, shift in zip(
            data["pose_pairs.prev"], data["pose_pairs.cur"],
            data["pose_pairs.delta_ea"], data["pose_pairs.delta_pos"], strict=True,
        ):  # fmt: skip
            graph.add(gtsam.BetweenFactorPose3(int(i), int(j), _pose(turn, shift), moved))
        held = gtsam.noiseModel.Diagonal.Sigmas(np.array([np.deg2rad(0.01)] * 3 + [0.001] * 3))
        anchor = _pose(data["anchors.ea"][0], data["anchors.pos"][0])
        graph.add(gtsam.PriorFactorPose3(int(data["anchors.pose"][0]), anchor, held))
        super().__init__(graph, initial)

    def answer(self) -> dict[str, np.ndarray]:
        values = self.optimizer.values()
        poses = [values.atPose3(k) for k in range(self.poses)]
        planes = [values.atOrientedPlane3(gtsam.symbol("p", j)) for j in range(self.planes)]
        return {
            "pos": np.array([p.translation() for p in poses]),
            "rotation": np.array([p.rotation().matrix() for p in poses]),
            "n": np.array([p.normal().point3() for p in planes]),
            "c": np.array([p.distance() for p in planes]),
        }


def _pose(ea: np.ndarray, pos: np.ndarray) -> gtsam.Pose3:
    return gtsam.Pose3(gtsam.Rot3.Ypr(*ea[::-1]), pos)


if __name__ == "__main__":
    main(
        "GTSAM " + getattr(gtsam, "__version__", "4.3"),
        {
            "pose_graph": PoseGraph,
            "bundle": Bundle,
            "slam": Slam,
            "localization": partial(Slam, known=True),
            "plane": Plane,
        },
    )

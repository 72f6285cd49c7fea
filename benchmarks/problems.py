"""The problems of the suites as files, and the states by which answers are compared.

A *state* is a dict of arrays that every system can give:

- pose graphs: ``id``, ``t`` and ``q`` (w x y z) or ``th``;
- bundles: ``r`` (rotation vectors), ``t``, ``f``, ``k1``, ``k2``, ``pos``;
- scenes: ``pos``, ``rotation`` (matrices, body to world), ``landmarks``;
- maps of planes: ``pos``, ``rotation``, ``n``, ``c``.

`last_pass` is the pass that is measured: the whole problem from the start of the file.

`Reference.cost` is the one judge: arael's model in f64, whoever solved it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import arael
from arael.geometry import euler_angles
from arael.runtime.store import rotations
from arael.scenes import PlaneScene, Scene, columns, fill
from arael.scenes.cameras import camera_ring

State = dict[str, np.ndarray]


def pose_graph_model(path: str | Path) -> str:
    """Name of the standard model of a g2o file."""
    with open(path, encoding="utf-8") as file:
        return "pose_graph_3d" if "SE3" in file.readline() else "pose_graph_2d"


@dataclass(frozen=True)
class PoseGraph:
    """g2o files."""

    last_pass: str = "refine"

    def load(self, path: str, precision: Any = None) -> Any:
        instance = arael.load(pose_graph_model(path), precision=precision)()
        instance.read(path)
        return instance

    def state(self, instance: Any) -> State:
        poses = instance.poses
        turn = "th" if instance.layout.name.endswith("2d") else "q"
        found = {"id": poses.id, "t": poses.t.value, turn: poses[turn].value}
        return {name: np.array(value) for name, value in found.items()}

    def put(self, instance: Any, state: State) -> None:
        row = {int(i): k for k, i in enumerate(state["id"])}
        order = [row[int(i)] for i in instance.poses.id]
        instance.poses.t.value[:] = state["t"][order]
        turn = "th" if "th" in state else "q"
        instance.poses[turn].value[:] = state[turn][order]


@dataclass(frozen=True)
class Bundle:
    """BAL files."""

    last_pass: str = "refine"

    def load(self, path: str, precision: Any = None) -> Any:
        instance = arael.load("bundle_adjustment", precision=precision)()
        instance.read(path, "bal")
        return instance

    def state(self, instance: Any) -> State:
        cameras = instance.cameras
        found = {
            "r": rotations.vector_from_quaternion(np.asarray(cameras.r.value, dtype=np.float64))
        }
        found |= {name: np.array(cameras[name].value) for name in ("t", "f", "k1", "k2")}
        return {**found, "pos": np.array(instance.points.pos.value)}

    def put(self, instance: Any, state: State) -> None:
        instance.cameras.r.value[:] = rotations.quaternion_from_vector(state["r"])
        for name in ("t", "f", "k1", "k2"):
            instance.cameras[name].value[:] = state[name]
        instance.points.pos.value[:] = state["pos"]


@dataclass(frozen=True)
class Slam:
    """Scenes as `write_scene` writes them."""

    model: str = "slam"
    last_pass: str = "fine"

    def load(self, path: str, precision: Any = None) -> Any:
        model = arael.load(self.model, precision=precision)
        # Robust weights far out: a peer has none, and no association is wrong here.
        instance = model(gamma=1e6)
        with np.load(path) as file:
            prefix = f"{self.model}/"
            found = {k.removeprefix(prefix): file[k] for k in file.files if k.startswith(prefix)}
        fill(instance, model.layout, found)
        return instance

    def state(self, instance: Any) -> State:
        found = {"pos": instance.poses.pos.value, "rotation": instance.poses.ea.matrix}
        if self.model == "slam":
            found["landmarks"] = instance.landmarks.pos.value
        return {name: np.array(value, dtype=np.float64) for name, value in found.items()}

    def put(self, instance: Any, state: State) -> None:
        instance.poses.pos.value[:] = state["pos"]
        instance.poses.ea.value[:] = euler_angles(state["rotation"].reshape(-1, 3, 3))
        if self.model == "slam":
            instance.landmarks.pos.value[:] = state["landmarks"]


@dataclass(frozen=True)
class Plane:
    """Maps of planes as `write_planes` writes them."""

    last_pass: str = "refine"

    def load(self, path: str, precision: Any = None) -> Any:
        model = arael.load("plane_slam", precision=precision)
        instance = model()
        with np.load(path) as file:
            fill(instance, model.layout, {name: file[name] for name in file.files})
        return instance

    def state(self, instance: Any) -> State:
        found = {
            "pos": instance.poses.pos.value,
            "rotation": instance.poses.ea.matrix,
            "n": instance.planes.n.value,
            "c": instance.planes.c.value,
        }
        return {name: np.array(value, dtype=np.float64) for name, value in found.items()}

    def put(self, instance: Any, state: State) -> None:
        instance.poses.pos.value[:] = state["pos"]
        instance.poses.ea.value[:] = euler_angles(state["rotation"].reshape(-1, 3, 3))
        instance.planes.n.value[:] = state["n"]
        instance.planes.c.value[:] = state["c"]


KINDS = {
    "pose_graph": PoseGraph(),
    "bundle": Bundle(),
    "slam": Slam(),
    "localization": Slam("localization"),
    "plane": Plane(),
}


class Reference:
    """A problem in arael's model in f64, loaded once, by which all answers are scored."""

    def __init__(self, suite: str, path: str) -> None:
        self.kind, self.path = KINDS[suite], path
        self.instance = self.kind.load(path, precision="f64")

    def cost(self, state: State) -> float:
        """Cost of a state."""
        self.kind.put(self.instance, state)
        return float(self.instance.cost())

    def least(self) -> float:
        """Cost where arael ends from the start of the file, to the last digit."""
        instance = self.kind.load(self.path, precision="f64")
        return float(instance.solve(passes=self.kind.last_pass, rel_precision=1e-14).end_cost)


def write_planes(scene: PlaneScene, path: Path) -> None:
    """Write a map of planes: the columns of the model."""
    np.savez(path, **scene.columns)  # type: ignore[arg-type]


def write_scene(scene: Scene, path: Path) -> None:
    """Write a scene for all systems: columns of the models, and what peers need by plain names.

    Cameras of the scene mirror their images; a peer's do not, so axes and pixels have x turned.
    """
    found: dict[str, Any] = {}
    for name in ("slam", "localization"):
        found |= {f"{name}/{k}": v for k, v in columns(scene, name).items()}  # type: ignore[arg-type]
    seen, sensors = scene.observations, scene.sensors
    pixel = seen.pixel.copy()
    pixel[:, 0] = 1024 - pixel[:, 0]
    cameras = camera_ring()
    np.savez(
        path,
        **found,
        pos=scene.start_pos,
        ea=scene.start_ea,
        landmarks=scene.start_landmarks,
        true_landmarks=scene.landmarks,
        obs_pose=seen.pose,
        obs_landmark=seen.landmark,
        obs_camera=seen.camera,
        obs_pixel=pixel,
        camera_pos=np.stack([c.pos for c in cameras]),
        camera_axes=np.stack([c.axes * [-1.0, 1.0, 1.0] for c in cameras]),
        gps=sensors.gps,
        tilt=sensors.tilt,
        delta_pos=sensors.delta_pos,
        delta_ea=sensors.delta_ea,
        delta_pos_sigma=sensors.delta_pos_sigma,
        delta_ea_sigma=sensors.delta_ea_sigma,
    )

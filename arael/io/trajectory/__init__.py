"""Trajectories: TUM, KITTI and EuRoC files, and collections of poses."""

from arael.io.trajectory.fields import PoseFields, fill, find, trajectory_of
from arael.io.trajectory.record import Trajectory
from arael.io.trajectory.text import FORMATS, dump, parse

__all__ = [
    "FORMATS",
    "PoseFields",
    "Trajectory",
    "dump",
    "fill",
    "find",
    "parse",
    "trajectory_of",
]

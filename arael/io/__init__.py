"""Readers and writers of data files, one module per format."""

from arael.diagnostics.model_warnings import DataWarning
from arael.io.formats import FORMATS, format_of, read, write
from arael.io.several import read_several
from arael.io.trajectories import read_trajectory, trajectory_of, write_trajectory
from arael.io.trajectory import Trajectory

__all__ = [
    "FORMATS",
    "DataWarning",
    "Trajectory",
    "format_of",
    "read",
    "read_several",
    "read_trajectory",
    "trajectory_of",
    "write",
    "write_trajectory",
]

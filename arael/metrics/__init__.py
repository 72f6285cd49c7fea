"""Errors of trajectories: association by time, alignment, ATE and RPE."""

from arael.io.trajectory import Trajectory
from arael.metrics.alignment import Alignment, align, align_origin, umeyama
from arael.metrics.association import associate
from arael.metrics.errors import Errors, Statistics, ate, rpe
from arael.metrics.pairs import pairs_of

__all__ = [
    "Alignment",
    "Errors",
    "Statistics",
    "Trajectory",
    "align",
    "align_origin",
    "associate",
    "ate",
    "pairs_of",
    "rpe",
    "umeyama",
]

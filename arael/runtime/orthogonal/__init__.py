"""Rank, dependencies and null space of sparse matrices by orthogonal factorisation."""

from arael.runtime.orthogonal.compiled import RankQR
from arael.runtime.orthogonal.results import Dependency, Vectors

__all__ = ["Dependency", "RankQR", "Vectors"]

"""Pose graphs in g2o's text format, for models like pose_graph_2d and pose_graph_3d."""

from arael.io.g2o.reader import read
from arael.io.g2o.writer import check, dump, dump_toro

__all__ = ["check", "dump", "dump_toro", "read"]

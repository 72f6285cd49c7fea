"""Many problems, and problems in parts, on a Dask cluster (extra ``distributed``)."""

from __future__ import annotations

from arael.distributed.cluster import connect
from arael.distributed.many import map
from arael.distributed.parts.api import solve

__all__ = ["connect", "map", "solve"]

"""Many problems, and problems in parts, on a Dask cluster (extra ``distributed``)."""

from __future__ import annotations

from arael.distributed.cluster import connect
from arael.distributed.many import map

__all__ = ["connect", "map"]

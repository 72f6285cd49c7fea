"""One problem in parts on Dask."""

from arael.distributed.parts.api import solve

__all__ = ["solve"]

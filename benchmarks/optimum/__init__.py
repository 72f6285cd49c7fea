"""How soon each system is at the optimum, and how soon it says so: the suite `optimum`."""

from benchmarks.optimum.chapter import run

__all__ = ["run"]

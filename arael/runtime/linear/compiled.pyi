from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy import bool_, int64
from numpy.typing import ArrayLike, NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import Analysis
from arael.runtime.parallel.compiled import Kept

Ints = NDArray[int64]

class LinearSolver:
    single: bool
    pattern: BlockPattern
    plan: dict[str, Any]
    n: int
    threads: int
    raised: Kept
    def __init__(self, pattern: BlockPattern, single: bool = False) -> None: ...
    def use_threads(self, threads: int) -> None: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    def restart(self) -> None: ...
    def report(self) -> dict[str, Any]: ...
    def factorise(self, values: ArrayLike, diagonal: ArrayLike) -> int: ...
    def step(
        self, values: ArrayLike, diagonal: ArrayLike, b: ArrayLike
    ) -> tuple[int, NDArray[np.floating[Any]] | None]: ...
    def solved(self, b: ArrayLike) -> NDArray[np.floating[Any]]: ...

def load_blas() -> None: ...
def is_blas_loaded() -> bool: ...
def table_of(
    first: ArrayLike,
    height: ArrayLike,
    width: ArrayLike,
    place: ArrayLike,
    leading: ArrayLike,
    how: ArrayLike,
) -> NDArray[Any]: ...
def block_table(pattern: BlockPattern, leading: int) -> NDArray[Any]: ...

class BandSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        half_bandwidth: int | None = None,
        block_half_bandwidth: int | None = None,
    ) -> None: ...

class CholmodSolver(LinearSolver): ...

ENTITY: np.dtype[Any]
COUPLING: np.dtype[Any]
BLOCK: np.dtype[Any]
SLACK: int

def instruction_sets() -> tuple[str, ...]: ...
def use_instruction_set(name: str) -> None: ...

class Elimination:
    reduction: Reduction
    n: int
    threads: int
    def __init__(self, reduction: Reduction, dtype: Any) -> None: ...

class Sums:
    products: Products
    def __init__(self, of: Elimination, products: Products, dtype: Any) -> None: ...

class ConjugateSolver(LinearSolver):
    solves: int
    steps: int
    forcing: float
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool,
        reduction: Reduction,
        blocks: Products,
        formed: bool,
        parts: Sequence[tuple[Products, LinearSolver]],
        *,
        tolerance: float = 0.1,
        floor: float = 1e-6,
        iterations: int = 500,
    ) -> None: ...
    def restart(self) -> None: ...
    def report(self) -> dict[str, Any]: ...

class DenseSolver(LinearSolver): ...

class LapackBandSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        half_bandwidth: int | None = None,
        block_half_bandwidth: int | None = None,
    ) -> None: ...

class RemainingSolver(LinearSolver):
    """Solves for the scalars that remain; of solutions, the others stay as they are."""

    inner: LinearSolver
    def __init__(
        self,
        pattern: BlockPattern,
        inner: LinearSolver,
        scalars: NDArray[np.int64],
        values: NDArray[np.int64],
    ) -> None: ...

class SchurSolver(LinearSolver):
    inner: LinearSolver
    @property
    def reduction(self) -> Reduction: ...
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool,
        reduction: Reduction,
        products: Products,
        inner: LinearSolver,
    ) -> None: ...

class SparseSolver(LinearSolver):
    def __init__(
        self,
        pattern: BlockPattern,
        single: bool = False,
        ordering: str = "auto",
        analysis: Analysis | None = None,
    ) -> None: ...
    def factor_forward(self, values: ArrayLike, diagonal: ArrayLike, b: ArrayLike) -> int: ...
    def forward(self, b: ArrayLike) -> None: ...
    def backward(self) -> NDArray[Any]: ...
    def parts(
        self,
    ) -> tuple[NDArray[int64], NDArray[Any], NDArray[Any], NDArray[Any], NDArray[int64]]: ...

PADDING: int

class Reduction:
    pattern: BlockPattern
    eliminated: NDArray[bool_]
    kept: Ints
    entities: NDArray[Any]
    couplings: NDArray[Any]
    entity_of: Ints
    scalars: Ints
    padded: Ints
    padded_size: int
    factor_size: int
    stored_size: int
    @property
    def sizes(self) -> Ints: ...

class Products:
    pattern: BlockPattern
    sources: Ints
    tasks: Ints
    pairs: NDArray[Any]

def reduce(pattern: BlockPattern, eliminated: NDArray[bool_]) -> Reduction: ...
def kept_blocks(r: Reduction) -> Products: ...
def products(r: Reduction, group: Ints | None = None, reach: int | None = None) -> Products: ...

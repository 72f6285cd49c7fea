from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

def fingerprint(
    array: NDArray[Any],
) -> tuple[int, int, int, int, tuple[int, ...], str]: ...
def fingerprints(arrays: list[NDArray[Any]]) -> list[tuple[Any, ...]]: ...
def fingerprint_of_flags(arrays: list[NDArray[Any]]) -> tuple[int, int, int, int]: ...
def taken(
    values: NDArray[Any], components: list[int], rows: NDArray[np.int64]
) -> NDArray[np.float64]: ...
def followed(targets: NDArray[np.int64], rows: NDArray[np.int64]) -> NDArray[np.int64]: ...
def join_columns(columns: list[NDArray[Any]], starts: list[int], found: NDArray[Any]) -> None: ...
def split_columns(
    state: NDArray[Any],
    starts: list[int],
    columns: list[NDArray[Any]],
    free: NDArray[np.bool_] | None,
    firsts: list[int],
    counts: list[int],
) -> None: ...
def solved_scalars(
    states: list[NDArray[Any]], flags: list[NDArray[np.bool_]], widths: list[int]
) -> NDArray[np.float64]: ...
def spread_rows(
    values: NDArray[Any], lanes: int, order: NDArray[np.int64] | None = None
) -> NDArray[Any]: ...
def spread_all(
    arrays: Sequence[NDArray[Any]],
    lanes: int,
    order: NDArray[np.int64] | None = None,
    known: Sequence[NDArray[Any]] | None = None,
    kept: int = 0,
) -> list[NDArray[Any]]: ...
def rows_of_handles(
    handles: NDArray[np.int64],
    positions: NDArray[np.int64],
    generations: NDArray[np.int64],
    start: int,
    shift: int,
) -> NDArray[np.int64]: ...
def rows_where(
    n: int, required: list[NDArray[np.bool_]], refused: list[NDArray[np.bool_]]
) -> NDArray[np.bool_]: ...
def spread_flags(
    flags: NDArray[np.bool_], scalars: NDArray[np.bool_], first: int, count: int
) -> None: ...
def all_set(flags: NDArray[np.bool_]) -> bool: ...
def numbered(
    flags: list[NDArray[np.bool_]],
) -> tuple[
    list[tuple[NDArray[np.int64], NDArray[np.int64], bool]],
    NDArray[np.int64],
    NDArray[np.int64],
    list[int],
    int,
]: ...
def some_set(flags: NDArray[np.bool_]) -> NDArray[np.bool_]: ...
def held_of(
    flags: list[NDArray[np.bool_]], firsts: list[NDArray[np.int64]]
) -> tuple[NDArray[np.int64] | None, int]: ...

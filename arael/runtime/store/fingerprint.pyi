from typing import Any

from numpy.typing import NDArray

def fingerprint(
    array: NDArray[Any],
) -> tuple[int, int, int, int, tuple[int, ...], str]: ...
def fingerprint_of_flags(arrays: list[NDArray[Any]]) -> tuple[int, int, int, int]: ...

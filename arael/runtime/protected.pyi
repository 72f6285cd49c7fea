from typing import Any

from numpy.typing import NDArray

def read_only(*arrays: NDArray[Any]) -> None: ...

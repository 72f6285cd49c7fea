from typing import Any

import numpy as np

ENTITY: np.dtype[Any]
COUPLING: np.dtype[Any]
BLOCK: np.dtype[Any]
SLACK: int

def available() -> tuple[str, ...]: ...
def use(name: str) -> None: ...

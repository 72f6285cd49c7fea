"""A tape alone on the expression machine: on columns, or as the step of an entity's rows."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.machine.tape import Tape

class TapeProgram:
    inputs: int
    outputs: int

    def __init__(self, tape: Tape, inputs: int, natives: Sequence[str] = ()) -> None: ...
    def columns(
        self,
        inputs: Sequence[NDArray[Any]],
        n: int,
        dtype: np.dtype[Any],
        natives: Any = None,
    ) -> NDArray[Any]: ...

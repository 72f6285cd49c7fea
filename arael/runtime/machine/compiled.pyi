from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Entity, Function, Group
from arael.runtime.machine.native_binding import Binding
from arael.runtime.machine.tape import Tape

class NativeTable:
    failure: BaseException | None
    names: list[str]
    bindings: dict[str, Binding]
    def __init__(self, functions: Sequence[Function], bindings: Mapping[str, Binding]) -> None: ...
    def clear(self) -> None: ...
    def raise_failure(self) -> None: ...
    def __getitem__(self, name: str) -> Callable[..., Any]: ...

WIDTH: int

class Program:
    single: bool
    uses: int
    residuals: int
    guarded: bool
    def __init__(
        self,
        group: Group,
        entities: Sequence[Entity],
        single: bool,
        natives: Sequence[str] = (),
    ) -> None: ...
    @property
    def instructions(self) -> tuple[int, int]: ...
    @property
    def workspace(self) -> int: ...

def limit_workspace(most: int | None = None) -> None: ...

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

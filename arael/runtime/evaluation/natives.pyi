from collections.abc import Callable, Mapping, Sequence
from typing import Any

from arael.runtime.evaluation.native_binding import Binding
from arael.runtime.layout import Function

class NativeTable:
    failure: BaseException | None
    names: list[str]
    bindings: dict[str, Binding]
    def __init__(self, functions: Sequence[Function], bindings: Mapping[str, Binding]) -> None: ...
    def clear(self) -> None: ...
    def raise_failure(self) -> None: ...
    def __getitem__(self, name: str) -> Callable[..., Any]: ...

from collections.abc import Sequence

from arael.runtime.layout import Entity, Group

WIDTH: int

class Program:
    single: bool
    uses: int
    residuals: int
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

"""Where the kernels of each group read, whole and share by share."""

from collections.abc import Sequence
from typing import Any

from numpy.typing import NDArray

from arael.runtime.assembly.shares import Shares
from arael.runtime.evaluation.instances import Instances
from arael.runtime.evaluation.natives import NativeTable
from arael.runtime.evaluation.state_pair import StatePair
from arael.runtime.layout import Group

class GroupLanes:
    """The lanes of all groups."""

    data: list[tuple[NDArray[Any], NDArray[Any]]]

    def __init__(
        self,
        groups: Sequence[Group],
        instances: Sequence[Instances],
        plan: Shares,
        widths: Sequence[int],
        states: StatePair,
        natives: NativeTable,
    ) -> None: ...
    def replace(self, g: int, one: Instances) -> None: ...

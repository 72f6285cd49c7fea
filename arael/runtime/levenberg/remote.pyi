from typing import Any

from numpy import float64
from numpy.typing import NDArray

from arael.runtime.assembly.components import Partition
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.evaluation.evaluation import Evaluation
from arael.runtime.levenberg.box import Box
from arael.runtime.linear.base import LinearSolver

Floats = NDArray[float64]

class RemoteEvaluation(Evaluation):
    parts: Any
    def is_guarded(self, guarded: bool) -> None: ...

class RemoteBox(Box):
    parts: Any

class RemoteSolver(LinearSolver):
    parts: Any
    def __init__(self, pattern: BlockPattern, parts: Any) -> None: ...

def curvature_of(
    box: Box, values: Floats, step: Floats, partition: Partition | None = None
) -> Floats: ...

from typing import Any

from arael.runtime.evaluation.evaluation import Evaluation

class InnerSteps:
    count: int
    def __init__(
        self, evaluation: Evaluation, entities: Any, partition: Any, floor: float
    ) -> None: ...

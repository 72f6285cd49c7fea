"""The cost by constraint."""

from __future__ import annotations

from arael.runtime.problem import Problem


class CostTable(dict[str, float]):
    """Sum of squared residuals by label (``PointFrine.bearing``), in the order of the model.

    Attributes
    ----------
    instances : number of active instances by label
    """

    def __init__(self, costs: dict[str, float], instances: dict[str, int]) -> None:
        super().__init__(costs)
        self.instances = instances

    @property
    def total(self) -> float:
        """The whole cost."""
        return sum(self.values())

    def __str__(self) -> str:
        rows = [(label, f"{cost:.6g}", str(self.instances[label])) for label, cost in self.items()]
        rows.append(("total", f"{self.total:.6g}", str(sum(self.instances.values()))))
        head = ("constraint", "cost", "instances")
        widths = [max(len(row[k]) for row in [head, *rows]) for k in range(3)]
        return "\n".join(
            f"{label:<{widths[0]}}  {cost:>{widths[1]}}  {count:>{widths[2]}}".rstrip()
            for label, cost, count in [head, *rows]
        )


def cost_table(problem: Problem) -> CostTable:
    """Cost of every constraint, also of those without an active instance (0)."""
    costs: dict[str, float] = {}
    instances: dict[str, int] = {}
    for number, group in enumerate(problem.layout.groups):
        costs[group.label] = costs.get(group.label, 0.0) + problem.evaluation.group_cost(number)
        count = len(problem.structure.active[number])
        instances[group.label] = instances.get(group.label, 0) + count
    return CostTable(costs, instances)

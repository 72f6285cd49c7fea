"""The cost by constraint."""

from __future__ import annotations

from arael.diagnostics.arguments import wrong_argument
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.runtime.problem import Problem


class CostTable(Displayed, dict[str, float]):
    """Sum of squared residuals by label (``PointFrine.bearing``), in the order of the model.

    Attributes
    ----------
    instances : number of active instances by label; 0: every guard is false, or the list is empty
    residuals : number of residuals by label
    violations : largest violation by label of what holds exactly (`require`), which costs nothing
    """

    def __init__(
        self,
        costs: dict[str, float],
        instances: dict[str, int],
        residuals: dict[str, int],
        violations: dict[str, float] | None = None,
    ) -> None:
        super().__init__(costs)
        self.instances = instances
        self.residuals = residuals
        self.violations = violations or {}

    def rms(self, label: str) -> float:
        """Root mean square of the residuals of a label: near 1 if the sigmas are right."""
        if not isinstance(label, str) or label not in self:
            raise wrong_argument("rms", "label", f"one of {', '.join(self)}", label)
        count = self.residuals[label]
        return float((self[label] / count) ** 0.5) if count else 0.0

    @property
    def total(self) -> float:
        """The total cost."""
        return sum(self.values())

    def _sheet(self) -> Sheet:
        rows = [
            (label, f"{cost:.6g}", str(self.instances[label]), f"{self.rms(label):.3g}")
            for label, cost in self.items()
        ]
        rows.append(("total", f"{self.total:.6g}", str(sum(self.instances.values())), ""))
        rows += [
            (label, "holds" if violation < 1e-6 else f"off by {violation:.3g}", "", "")
            for label, violation in self.violations.items()
        ]
        return Sheet("cost by constraint", ("constraint", "cost", "instances", "rms"), rows)

    def __str__(self) -> str:
        sheet = self._sheet()
        head, rows = sheet.head, sheet.rows
        widths = [max(len(row[k]) for row in [head, *rows]) for k in range(4)]
        return "\n".join(
            "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip()
            for row in [head, *rows]
        )


def cost_table(problem: Problem) -> CostTable:
    """Cost of every constraint, also of those without an active instance (0)."""
    costs: dict[str, float] = {}
    instances: dict[str, int] = {}
    residuals: dict[str, int] = {}
    violations: dict[str, float] = {}
    for number, group in enumerate(problem.layout.groups):
        if group.require:
            rows = problem.evaluation.group_rows(number)[0]
            off = abs(rows) if group.require == "equal" else -rows
            worst = max(0.0, float(off.max(initial=0.0)))
            violations[group.label] = max(violations.get(group.label, 0.0), worst)
            continue
        costs[group.label] = costs.get(group.label, 0.0) + problem.evaluation.group_cost(number)
        count = int(problem.evaluation.acting(number).sum())
        instances[group.label] = instances.get(group.label, 0) + count
        residuals[group.label] = residuals.get(group.label, 0) + count * group.residuals
    return CostTable(costs, instances, residuals, violations)

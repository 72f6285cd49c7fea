"""The scalar operations and functions of formulas: one record each, for every part of arael."""

from arael.operations.record import Domain, Operation
from arael.operations.table import OPERATIONS

__all__ = ["OPERATIONS", "Domain", "Operation"]

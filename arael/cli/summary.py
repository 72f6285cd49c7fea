"""A solve's result as data for JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from arael.result import Result


def as_dict(result: Result) -> dict[str, Any]:
    """Return a result, and each of its passes, as data for JSON."""
    found: dict[str, Any] = plain({**result.to_dict(), "converged": has_converged(result)})
    return found


def plain(value: Any) -> Any:
    """Replace non-finite numbers by None, recursively."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


def has_converged(result: Result) -> bool:
    """Whether every pass converged."""
    return all(one.converged for one in result.passes or (result,))

"""The scalar functions of the language, by name."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from arael.symbolic.scalars import angles, elementary, robust, safe, steps
from arael.symbolic.scalars.function import ScalarFunction

SCALARS: Mapping[str, ScalarFunction] = MappingProxyType(
    {
        function.name: function
        for family in (elementary, steps, safe, angles, robust)
        for function in family.FUNCTIONS
    }
)

__all__ = ["SCALARS", "ScalarFunction"]

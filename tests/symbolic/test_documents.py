"""The page on the engine agrees with the table of scalar functions."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.manifolds.parameters import PARAMETERS
from arael.symbolic.scalars import SCALARS

PAGE = Path(__file__).parents[2] / "docs" / "internals" / "symbolic.md"


@pytest.mark.parametrize("name", SCALARS)
def test_scalar_function_is_documented(name: str) -> None:
    function = SCALARS[name]
    arguments = f"({', '.join('xyz'[: function.arity])})" if function.arity else ""
    cells = [function.value, function.derivative, function.singular]
    row = f"| `{name}{arguments}` | " + " | ".join(c.replace("|", "\\|") for c in cells) + " |"
    assert row in PAGE.read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("name", PARAMETERS)
def test_parameter_type_is_documented(name: str) -> None:
    kind = PARAMETERS[name]
    head = f"| `{name}` | {kind.storage} | {kind.tangent_width} |"
    assert head in PAGE.read_text(encoding="utf-8")

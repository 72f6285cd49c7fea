from __future__ import annotations

from tests.cli.conftest import arael

__all__ = ["arael"]

"""Mixin of classes that notebooks and rich show as a table."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Group

    from arael.display.sheet import Sheet


class Displayed:
    """Shown by Jupyter (`_repr_html_`) and by `rich.print` (`__rich__`) as its sheet."""

    __slots__ = ()

    @abstractmethod
    def _sheet(self) -> Sheet:
        """The table; each class has its own."""

    def _repr_html_(self) -> str:
        return self._sheet().html()

    def __rich__(self) -> Group:
        return self._sheet().rich()

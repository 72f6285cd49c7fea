"""Every node of a tree."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

from arael.syntax.tree import File, Node


def walk(node: File | Node | tuple[Any, ...]) -> Iterator[Node]:
    """Nodes of `node` and below it, parents before children, in the order of the text."""
    stack: list[Any] = [node]
    while stack:
        here = stack.pop()
        if isinstance(here, tuple):
            stack.extend(reversed(here))
        elif isinstance(here, File):
            stack.extend(reversed(here.items))
        elif isinstance(here, Node):
            yield here
            stack.extend(
                getattr(here, f.name)
                for f in reversed(fields(here))
                if f.name not in ("span", "name_span")
            )

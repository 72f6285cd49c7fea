"""Colours and shapes by role, for light and dark backgrounds.

Colours are from the palette of Okabe and Ito (2008), which stays distinct with colour-blind sight.
States differ by shape as well: see `STATES`.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

Theme: TypeAlias = Literal["light", "dark"]

STYLE_DASHES: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {"solid": (), "dashed": (9.0, 5.0), "dashdot": (12.0, 4.0, 1.5, 4.0)}
)

CONSTRUCTION_DASH = (4.0, 4.0)


class Appearance(NamedTuple):
    """How a state is shown besides its colour.

    Attributes
    ----------
    width : of the curve, pixels
    halo : width of a stroke behind it, 0 for none
    halo_dash : dashes of that stroke
    end : shape of the points: ``ring``, ``disc``, ``square``, ``cross``, ``diamond``
    """

    width: float
    halo: float
    halo_dash: tuple[float, ...]
    end: str


STATES: Mapping[str, Appearance] = MappingProxyType(
    {
        "free": Appearance(1.7, 0.0, (), "ring"),
        "defined": Appearance(2.1, 0.0, (), "disc"),
        "redundant": Appearance(2.1, 8.0, (2.0, 5.0), "diamond"),
        "impossible": Appearance(2.1, 8.0, (9.0, 4.0), "cross"),
        "selected": Appearance(2.1, 9.0, (), "square"),
    }
)
"""States of geometry; construction is a flag of the entity, and drawn by thin dashes."""

_LIGHT = {
    "background": "#ffffff",
    "grid": "#eef0f3",
    "free": "#0072b2",
    "defined": "#1a1d21",
    "redundant": "#b86e00",
    "impossible": "#c8310c",
    "selected": "#b0387f",
    "construction": "#6b7684",
    "halo.redundant": "#e69f00",
    "halo.impossible": "#e0592f",
    "halo.selected": "#f0a8d2",
    "dimension": "#3f6b57",
    "derived": "#7d8791",
    "glyph": "#4a5560",
    "glyph.back": "#f4f6f8",
    "glyph.edge": "#c9d0d7",
    "note": "#7d8791",
}

_DARK = {
    "background": "#15181c",
    "grid": "#20252b",
    "free": "#56b4e9",
    "defined": "#eceff2",
    "redundant": "#f0b545",
    "impossible": "#ff7a55",
    "selected": "#ec8fc4",
    "construction": "#8b96a3",
    "halo.redundant": "#8a6410",
    "halo.impossible": "#8f3417",
    "halo.selected": "#6d2f53",
    "dimension": "#7fcfa9",
    "derived": "#8b96a3",
    "glyph": "#b9c3cd",
    "glyph.back": "#242a31",
    "glyph.edge": "#3d4650",
    "note": "#8b96a3",
}

THEMES: Mapping[Theme, Mapping[str, str]] = MappingProxyType(
    {"light": MappingProxyType(_LIGHT), "dark": MappingProxyType(_DARK)}
)

FONT = "'Inter', 'Segoe UI', 'Helvetica Neue', 'DejaVu Sans', Arial, sans-serif"

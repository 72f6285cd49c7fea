"""Figures in a common style, saved without a display and without global state."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import cache, wraps
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import write_whole

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

P = ParamSpec("P")

BLUE = "#1f5fa8"
ORANGE = "#d9601a"
GREEN = "#2a7f4f"
GREY = "#8a8f98"
INK = "#22262b"
FAINT = "#d5d9df"

_STYLE: Any = {
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.edgecolor": GREY,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": GREY,
    "ytick.color": GREY,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "svg.hashsalt": "arael",
}

FORMATS = (".png", ".pdf", ".svg")


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorator that applies the common style to a function that draws a figure.

    Raises
    ------
    AraelError
        E0860 on a call, if matplotlib is not installed.
    """

    @wraps(draw)
    def drawn(*args: P.args, **kwargs: P.kwargs) -> Figure:
        require_matplotlib()
        # imported here: start-up time
        import matplotlib

        with matplotlib.rc_context(_STYLE):
            return draw(*args, **kwargs)

    return drawn


def require_matplotlib() -> None:
    """Raise AraelError (E0860) if matplotlib is not installed."""
    if find_spec("matplotlib") is None:
        raise AraelError(
            Diagnostic(
                "E0860",
                "figures need matplotlib, which is not installed",
                origin="--plot",
                help=("pip install 'arael[plot]'",),
            )
        )


def empty_figure(width: float, height: float) -> Figure:
    """Create a figure without axes, which a notebook shows as a picture."""
    found: Figure = _shown_in_notebooks()(figsize=(width, height), layout="constrained")
    return found


@cache
def _shown_in_notebooks() -> Any:
    # imported here: start-up time
    from matplotlib.figure import Figure

    class Picture(Figure):
        """A figure that shows itself, whether or not pyplot was imported."""

        def _repr_png_(self) -> bytes:
            content = io.BytesIO()
            self.savefig(content, format="png", dpi=80)
            return content.getvalue()

    return Picture


def new_figure(
    width: float, height: float, columns: int = 1, rows: int = 1
) -> tuple[Figure, list[Axes]]:
    """Create a figure of `width` by `height` inches with axes in `rows`, row by row."""
    figure = empty_figure(width, height)
    axes = [figure.add_subplot(rows, columns, k + 1) for k in range(rows * columns)]
    for one in axes:
        one.set_axisbelow(True)
    return figure, axes


def check_format(path: Path) -> None:
    """Reject an invalid picture file name before any computation.

    Raises
    ------
    AraelError
        E0861 if its extension is not a picture format.
    """
    if path.suffix.lower() not in FORMATS:
        raise AraelError(
            Diagnostic(
                "E0861",
                f"expected a picture file ({', '.join(FORMATS)}), found extension `{path.suffix}`",
                origin=str(path),
                help=(f"for instance {path.with_suffix('.png').name}",),
            )
        )


def save(figure: Figure, path: Path) -> str:
    """Write the figure atomically; return the file's name.

    Raises
    ------
    AraelError
        E0715 if it cannot be written, E0861 if its extension is not a picture format.
    """
    # imported here: start-up time
    import matplotlib

    check_format(path)
    content = io.BytesIO()
    with matplotlib.rc_context(_STYLE):
        kind = path.suffix.lower().removeprefix(".")
        figure.savefig(content, format=kind, dpi=150, metadata=_no_date(path))
    write_whole(path, lambda file: file.write(content.getbuffer()))
    return str(path)


def beside(path: Path, what: str) -> Path:
    """File name for a further picture: ``run.png`` gives ``run-hessian.png``."""
    return path.with_name(f"{path.stem}-{what}{path.suffix}")


def _no_date(path: Path) -> dict[str, None]:
    """Metadata without a date, so that the output is reproducible."""
    return {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(path.suffix.lower(), {})

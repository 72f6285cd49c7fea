"""The one error of everything that cannot be solved."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from arael.diagnostics.records import AraelError, Diagnostic

if TYPE_CHECKING:
    from arael.runtime.layout import Layout


class SolveError(AraelError):
    """A problem that cannot be solved, named in the model's own words.

    Attributes
    ----------
    diagnostics : what is wrong and where
    best : the result up to the failure, with the best accepted state in ``best.x``; None if the
        failure came before there was a state
    """

    def __init__(self, diagnostics: Diagnostic | list[Diagnostic], best: Any = None) -> None:
        super().__init__(diagnostics)
        self.best = best


def listed(names: list[str], shown: int = 3) -> str:
    """Names in a row, the first few and how many more."""
    text = ", ".join(f"`{name}`" for name in names[:shown])
    more = len(names) - shown
    return f"{text} and {more} more" if more > 0 else text


def refuse_required(layout: Layout, what: str, help_: str) -> None:
    """Raise E1038 if a model has rows that hold exactly, which `what` does not support."""
    if layout.required:
        label = layout.groups[layout.required[0]].label
        raise AraelError(
            Diagnostic(
                "E1038",
                f"{what} cannot take what holds exactly: `{label}` is a `require`",
                origin=layout.name,
                help=(help_,),
            )
        )


class FunctionError(SolveError):
    """A function of the caller failed, or returned what cannot be used.

    The model keeps the best state that was accepted before.
    """

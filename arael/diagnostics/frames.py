"""Tracebacks of errors that a user can cause end at the public function that was called."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from types import TracebackType
from typing import ParamSpec, TypeVar

from arael.diagnostics.records import AraelError

_P = ParamSpec("_P")
_T = TypeVar("_T")

_OWN = (str(Path(__file__).parents[1]), "arael/", contextmanager.__code__.co_filename)
"""Beginnings of files of frames that are hidden; Cython has paths from the project's folder."""


class _UserFrames:
    """Shortens the traceback of an `AraelError` that leaves the block.

    The frame of the block stays, and what is below it down to the last frame of the user, such as
    that of a function which a solve calls. ``ARAEL_DEBUG=1`` leaves all frames.
    """

    def __enter__(self) -> None:
        pass

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if traceback is None or not isinstance(error, AraelError) or os.environ.get("ARAEL_DEBUG"):
            return
        last, here = traceback, traceback.tb_next
        while here is not None:
            if not here.tb_frame.f_code.co_filename.startswith(_OWN):
                last = here.tb_next or here
            here = here.tb_next
        last.tb_next = None


user_frames = _UserFrames()


def public(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """A public function whose errors have no frames of arael; of none that warns its caller."""

    @wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        __tracebackhide__ = True
        with user_frames:
            return function(*args, **kwargs)

    return call

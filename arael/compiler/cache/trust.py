"""Where the cache is, and which of its files are the user's own.

Compiled code is loaded into the process, so every folder and file on the path to it must belong
to the user and be writable by no other user. A folder that was writable by others for a while may
contain their files: correcting its permissions is not sufficient, each entry is checked.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import stat
import sys
from pathlib import Path

from arael.diagnostics.records import AraelError, Diagnostic

# Errors of writing a file if a disk, quota or limit is exhausted.
FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


def directory() -> Path:
    """Where compiled models are kept: ``ARAEL_CACHE_DIR``, else the user's cache directory."""
    chosen = os.environ.get("ARAEL_CACHE_DIR")
    if chosen:
        return Path(chosen).absolute()  # the compiler runs in another folder
    # imported here: start-up time
    from platformdirs import user_cache_path

    return user_cache_path("arael", appauthor=False)


def user() -> int:
    """The number of the user whose files are trusted."""
    return os.getuid() if sys.platform != "win32" else 0


def is_own(path: Path) -> bool:
    """Whether `path` is no link, belongs to the user, and is not writable by others."""
    if sys.platform == "win32":
        return path.exists()
    try:
        state = path.lstat()
    except OSError:
        return False
    if stat.S_ISLNK(state.st_mode):
        return False
    return state.st_uid == user() and not state.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


def is_trusted(path: Path) -> bool:
    """Whether `path` and the folders between it and the cache's own are the user's own.

    The cache's own folder may be a link: the user chose it.
    """
    root = directory()
    try:
        if not is_own(root.resolve()):
            return False
        steps = path.relative_to(root).parts
    except (OSError, RuntimeError, ValueError):
        return False
    return all(is_own(root.joinpath(*steps[: k + 1])) for k in range(len(steps)))


def prepare(*parts: str) -> Path:
    """Make the cache's folder, or a folder in it, private to the user; return its path.

    Anything in the place of a folder in it that is not private is removed or renamed. The names of
    these folders begin with ``arael-``, so that they are not those of the user's folders.

    Raises
    ------
    AraelError
        E0804 if it cannot be made, E0805 if the cache's own folder could be written by others.
    """
    path = directory()
    try:
        path.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not is_own(path.resolve()):
            raise open_to_others(path)
        for part in parts:
            path /= part
            if os.path.lexists(path) and not (is_own(path) and path.is_dir()):
                remove(path)
            path.mkdir(mode=0o700, exist_ok=True)
    except OSError as error:
        raise unwritable(error) from error
    return path


def remove(path: Path) -> None:
    """Remove `path`, or rename it if it contains files of another user.

    Raises
    ------
    OSError
        Neither is possible.
    """
    if path.is_symlink() or path.is_file():
        path.unlink()
        return
    shutil.rmtree(path, ignore_errors=True)
    if os.path.lexists(path):
        # imported here: start-up time
        import tempfile

        # Into a folder that was made just now: no other process can have taken its name.
        path.rename(Path(tempfile.mkdtemp(prefix="refused-", dir=path.parent)) / path.name)


def replace(path: Path, data: bytes) -> None:
    """Write a file of the cache as a whole, readable by the user only.

    Raises
    ------
    OSError
        The file cannot be written; nothing is left then.
    """
    # imported here: start-up time
    import tempfile

    number, name = tempfile.mkstemp(prefix="new-", dir=path.parent)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(data)
        os.replace(name, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise


def open_to_others(root: Path) -> AraelError:
    """The error for a cache that others can write, with what to do about it."""
    return AraelError(
        Diagnostic(
            "E0805",
            "the cache directory could be written by other users, so it is not used",
            origin=str(root),
            notes=("what is in it may be theirs, and compiled models are programs that are run",),
            help=open_advice(root),
        )
    )


def open_advice(root: Path) -> tuple[str, ...]:
    """What to do about a cache that others can write."""
    another = "choose another directory with the environment variable ARAEL_CACHE_DIR"
    try:
        is_users = sys.platform == "win32" or root.stat().st_uid == user()
    except OSError:
        is_users = False
    if not is_users:
        return (another,)
    return ("empty it and make it private: `arael cache clear`", another)


def unwritable(error: OSError) -> AraelError:
    """The error for a cache that cannot be written."""
    return AraelError(
        Diagnostic(
            "E0804",
            f"the cache of compiled models cannot be written: {error.strerror or error}",
            origin=str(directory()),
            help=("choose another directory with the environment variable ARAEL_CACHE_DIR",),
        )
    )

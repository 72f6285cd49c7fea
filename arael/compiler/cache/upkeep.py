"""Contents of the cache, clearing it, and keeping it small."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from arael.compiler.cache.kernels import Manifest, read_manifest
from arael.compiler.cache.keys import LENGTH, is_key
from arael.compiler.cache.locks import locked
from arael.compiler.cache.trust import directory, is_own, remove, user
from arael.diagnostics.records import AraelError

KEPT = 1000
"""Compiled models that are kept; where there are more, those used longest ago are removed."""

KEPT_TEXTS = 1000
"""Entries of texts that are kept. A text that is being edited makes one with each change."""

DAY = 86400.0


@dataclass(frozen=True)
class Cleared:
    """What `clear` did.

    Attributes
    ----------
    count, size : compiled models removed, and bytes of everything removed
    busy : folders that were left to another process, which compiles
    refused : paths of what could not be removed
    """

    count: int
    size: int
    busy: int
    refused: tuple[str, ...]


def entries() -> list[tuple[str, Manifest, int]]:
    """Key, manifest and bytes of all compiled kernels, newest first."""
    sizes = []
    for folder in _listed(directory() / "arael-kernels"):
        with contextlib.suppress(OSError, ValueError):
            sizes.append((folder.name, read_manifest(folder), _size(folder)))
    return sorted(sizes, key=lambda entry: -entry[1].made)


def trim() -> None:
    """Remove the least recently used entries beyond `KEPT`, and remains that are a day old."""
    root = directory()
    kernels = [p for p in _listed(root / "arael-kernels") if is_key(p.name)]
    for path in _oldest(kernels, KEPT):
        with _turn(path.name) as held:
            if held:
                shutil.rmtree(path, ignore_errors=True)
    for path in _oldest(_listed(root / "arael-models"), KEPT_TEXTS):
        with contextlib.suppress(OSError):
            path.unlink()
    for name in FOLDERS:
        for path in _listed(root / name):
            with contextlib.suppress(OSError):
                lasting = is_key(path.stem) and name != "arael-failed"
                if not lasting and path.lstat().st_mtime < time.time() - DAY:
                    remove(path)


def clear() -> Cleared:
    """Remove everything that arael put into the cache's folder, and make it private.

    Folders in which another process compiles are kept.
    """
    root = directory()
    keys = {key for key, _, _ in entries()}
    count = size = busy = 0
    left = []
    for path, key in _ours(root):
        with _turn(key) as held:
            if not held:
                busy += 1
                continue
            bytes_ = _size(path)
            with contextlib.suppress(OSError):
                remove(path)
            if os.path.lexists(path):
                left.append(str(path))
                continue
            size += bytes_
            count += path.name in keys
    if sys.platform != "win32":
        with contextlib.suppress(OSError):
            if root.stat().st_uid == user() and not is_own(root.resolve()):
                root.chmod(0o700)
    left += [str(path) for path, _ in _ours(root) if path.name.startswith("refused-")]
    return Cleared(count, size, busy, tuple(left))


FOLDERS = ("arael-models", "arael-kernels", "arael-failed")


def _ours(root: Path) -> Iterator[tuple[Path, str]]:
    """What arael made in the folder `root`; with it the key whose lock guards it, or ""."""
    for name in FOLDERS:
        folder = root / name
        if os.path.lexists(folder) and not is_own(folder):  # another user's, or a link elsewhere
            yield folder, ""
            continue
        for path in _listed(folder):
            key = path.name.removeprefix("build-")[:LENGTH]
            yield path, key if name == "arael-kernels" and is_key(key) else ""
    for path in _listed(root):
        # Entries and locks of earlier versions, and what could not be removed.
        if is_key(path.name.removesuffix(".lock")) or path.name.startswith("refused-"):
            yield path, ""


@contextlib.contextmanager
def _turn(key: str) -> Iterator[bool]:
    """Hold the lock of `key`, if `key` is not empty and no other process holds it."""
    if not key:
        yield True
        return
    with contextlib.ExitStack() as stack:
        try:
            held = stack.enter_context(locked(key, 0.0))
        except AraelError:  # no locks can be made here, so no process compiles
            held = True
        yield held


def _listed(folder: Path) -> list[Path]:
    try:
        return sorted(folder.iterdir())
    except OSError:
        return []


def _oldest(paths: list[Path], count: int) -> list[Path]:
    """All but the `count` paths that were used last."""
    used = []
    for path in paths:
        with contextlib.suppress(OSError):
            used.append((path.lstat().st_mtime, path))
    return [path for _, path in sorted(used, reverse=True)[count:]]


def _size(path: Path) -> int:
    """Bytes of a file, or of the files of a folder."""
    try:
        if path.is_dir() and not path.is_symlink():
            return sum(p.lstat().st_size for p in path.iterdir())
        return path.lstat().st_size
    except OSError:
        return 0

"""Compiled kernels, by the key of the code they were compiled from."""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
import sysconfig
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import msgspec

from arael.compiler.cache.keys import FORMAT, digest
from arael.compiler.cache.locks import locked
from arael.compiler.cache.trust import (
    FULL,
    directory,
    is_own,
    is_trusted,
    prepare,
    remove,
    unwritable,
)
from arael.diagnostics.records import AraelError
from arael.version import __version__

MANIFEST = "manifest.json"


class Manifest(msgspec.Struct, frozen=True):
    """What an entry consists of.

    Attributes
    ----------
    name : name of the model that was compiled first; others may have the same kernels
    source : name of its file, without the folder
    made : time, in seconds since 1970
    seconds : what each stage of the compilation took
    files : SHA-256 of each file of the entry
    key : key of the entry
    """

    format: int
    name: str
    source: str
    arael: str
    made: float
    compiler: str
    seconds: dict[str, float]
    files: dict[str, str]
    key: str = ""


@dataclass(frozen=True)
class Entry:
    """A verified entry."""

    folder: Path
    manifest: Manifest

    @property
    def module(self) -> Path | None:
        """The extension module; None if there is none for this Python."""
        suffix = sysconfig.get_config_var("EXT_SUFFIX") or ".so"
        for name in self.manifest.files:
            if name.endswith(suffix):
                return self.folder / name
        return None


def find(key: str) -> Entry | None:
    """Find the entry of `key` if it is there, the user's own, complete and unchanged."""
    folder = directory() / "arael-kernels" / key
    if not is_trusted(folder):
        return None
    entry = read_entry(folder)
    if entry is None or entry.module is None:
        return None
    if not all(is_own(folder / name) for name in (MANIFEST, *entry.manifest.files)):
        return None
    with contextlib.suppress(OSError):
        os.utime(folder)  # used: see `upkeep.trim`
    return entry


def read_entry(folder: Path) -> Entry | None:
    """Read the entry in `folder`, if it is complete and unchanged."""
    try:
        manifest = read_manifest(folder)
        if manifest.format != FORMAT:
            return None
        for name, expected in manifest.files.items():
            if os.path.basename(name) != name or digest((folder / name).read_bytes()) != expected:
                return None
    except (OSError, ValueError):
        return None
    return Entry(folder, manifest)


def recent(count: int) -> list[Entry]:
    """Up to `count` readable entries, the latest first; what they hold is not verified."""
    entries: list[tuple[float, Entry]] = []
    with contextlib.suppress(OSError, AraelError):
        for folder in (directory() / "arael-kernels").iterdir():
            with contextlib.suppress(OSError, ValueError):
                manifest = read_manifest(folder)
                entries.append((manifest.made, Entry(folder, manifest)))
    return [entry for _, entry in sorted(entries, key=lambda one: one[0])[::-1][:count]]


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest in `folder`.

    Raises
    ------
    OSError, ValueError
        There is none, or it is damaged.
    """
    return msgspec.json.decode((folder / MANIFEST).read_bytes(), type=Manifest)


@contextlib.contextmanager
def building(key: str) -> Iterator[Path]:
    """Hold the lock on `key` and yield a private folder to build in; it is removed afterwards.

    Raises
    ------
    AraelError
        E0804 the cache cannot be written, E0805 others could write it, E0806 another process holds
        the lock for too long.
    """
    # imported here: start-up time
    import tempfile

    root = prepare("arael-kernels")
    with locked(key):
        try:
            folder = Path(tempfile.mkdtemp(prefix=f"build-{key}-", dir=root))
        except OSError as error:
            raise unwritable(error) from error
        try:
            yield folder
        except OSError as error:
            if error.errno in FULL:
                raise unwritable(error) from error
            raise
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def store(
    key: str,
    built: Path,
    name: str,
    source: str,
    compiler: str,
    seconds: dict[str, float],
    check: Callable[[Path], object],
) -> Entry:
    """Move the files of the folder `built` into place as the entry of `key`.

    Parameters
    ----------
    check : called with the extension module in its place, before the manifest makes it an entry;
        what it raises is passed on, and nothing is stored
    """
    target = prepare("arael-kernels") / key
    try:
        if os.path.lexists(target):
            remove(target)
        os.replace(built, target)
        try:
            module = next(target.glob("*" + (sysconfig.get_config_var("EXT_SUFFIX") or ".so")))
            check(module)
            manifest = seal(target, key, name, source, compiler, seconds)
            _close(target)
        except BaseException:
            shutil.rmtree(target, ignore_errors=True)
            raise
    except OSError as error:
        raise unwritable(error) from error
    return Entry(target, manifest)


def seal(
    folder: Path, key: str, name: str, source: str, compiler: str, seconds: dict[str, float]
) -> Manifest:
    """Write the manifest of a folder, which makes it an entry."""
    manifest = Manifest(
        format=FORMAT,
        name=_encodable(name),
        source=_encodable(os.path.basename(source)),
        arael=__version__,
        made=time.time(),
        compiler=compiler,
        seconds=seconds,
        files={p.name: digest(p.read_bytes()) for p in sorted(folder.iterdir())},
        key=key,
    )
    (folder / MANIFEST).write_bytes(msgspec.json.encode(manifest))
    return manifest


def _close(folder: Path) -> None:
    """Remove the write permission of other users, which the compiler's umask may have granted."""
    if sys.platform != "win32":
        for path in folder.iterdir():
            path.chmod(0o700 if path.is_dir() else 0o600)


def _encodable(name: str) -> str:
    """A file's name as text that can be written as UTF-8."""
    return name.encode("utf-8", "replace").decode()

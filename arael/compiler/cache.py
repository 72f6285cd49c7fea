"""Compiled models on disk: private to the user, written whole, verified before they are loaded.

An entry is a folder named by its key::

    manifest.json   what it was made from, and the SHA-256 of each file below
    layout.json     the runtime's layout
    kernels_*.pyx   generated source
    kernels_*.so    the extension module (missing if there was no compiler)

The key covers everything that could change the result: source text, root, precision, arael's
version, the Python ABI, processor, compiler command and flags.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import shutil
import stat
import sys
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import msgspec

import arael
from arael.diagnostics.records import AraelError, Diagnostic

FORMAT = 1
KEPT = 200
"""Entries kept; where there are more, those used longest ago go."""


class Manifest(msgspec.Struct, frozen=True):
    """What an entry says of itself."""

    format: int
    name: str
    source: str
    arael: str
    made: float
    compiler: str
    seconds: dict[str, float]
    files: dict[str, str]  # name -> SHA-256
    key: str = ""
    dependencies: dict[str, str] = {}  # imported file -> SHA-256 of its text
    without: str = ""  # where there are no kernels: the compiler that failed


@dataclass(frozen=True)
class Entry:
    """A verified entry."""

    folder: Path
    manifest: Manifest

    @property
    def layout(self) -> bytes:
        """The layout as JSON."""
        return (self.folder / "layout.json").read_bytes()

    @property
    def module(self) -> Path | None:
        """The extension module, or None where the entry was made without a compiler."""
        suffix = sysconfig.get_config_var("EXT_SUFFIX") or ".so"
        for name in self.manifest.files:
            if name.endswith(suffix):
                return self.folder / name
        return None


# What writing to a file fails with for want of room.
_FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}


def digest(data: bytes) -> str:
    """SHA-256 as hexadecimal text."""
    return hashlib.sha256(data).hexdigest()


def directory() -> Path:
    """Where compiled models are kept: ``ARAEL_CACHE_DIR``, else the user's cache directory."""
    chosen = os.environ.get("ARAEL_CACHE_DIR")
    if chosen:
        return Path(chosen)
    from platformdirs import user_cache_path

    return user_cache_path("arael", appauthor=False)


def key(text: str, root: str | None, precision: str | None, target: str, beside: str = "") -> str:
    """Key of a model's entry; `beside` is the folder of a model that imports others."""
    parts = (
        str(FORMAT),
        arael.__version__,
        _package_stamp(),
        sysconfig.get_config_var("EXT_SUFFIX") or "",
        sys.version,
        _processor(),
        os.environ.get("CC", ""),
        os.environ.get("CFLAGS", ""),
        target,
        root or "",
        precision or "",
        beside,
        text,
    )
    return digest("\0".join(parts).encode("utf-8", "surrogatepass"))[:40]


def shipped_key(text: str, target: str) -> str:
    """Key of a model that was compiled when arael was installed."""
    suffix = sysconfig.get_config_var("EXT_SUFFIX") or ""
    return digest("\0".join((str(FORMAT), arael.__version__, suffix, target, text)).encode())


@lru_cache(maxsize=1)
def _package_stamp() -> str:
    """Digest the times of arael's own files, so that a checkout under work serves nothing stale."""
    stamps = []
    package = Path(__file__).parents[1]
    for room in ("check", "compiler", "runtime", "symbolic", "syntax"):
        for folder, _, names in os.walk(package / room):
            for name in names:
                if name.endswith((".py", ".pxd", ".lark")):
                    file = Path(folder, name)
                    with contextlib.suppress(OSError):
                        stamps.append(f"{file}:{file.stat().st_mtime_ns}")
    return digest("\n".join(sorted(stamps)).encode("utf-8", "surrogatepass"))


@lru_cache(maxsize=1)
def _processor() -> str:
    """Identify the instruction set that ``-march=native`` stands for."""
    import platform

    with contextlib.suppress(OSError), open("/proc/cpuinfo", encoding="utf-8") as file:
        for line in file:
            if line.startswith(("flags", "Features")):
                return platform.machine() + line
    return platform.machine() + platform.processor()


def find(key: str) -> Entry | None:
    """Find the entry of `key` if it is there, ours, complete and unchanged."""
    try:
        if not _is_private(directory()):
            return None
    except OSError:
        return None
    entry = read_entry(directory() / key)
    if entry:
        with contextlib.suppress(OSError):
            os.utime(entry.folder)  # used: see `_trim`
    return entry


def read_entry(folder: Path) -> Entry | None:
    """Read the entry in `folder`, if it is complete and unchanged."""
    try:
        manifest = msgspec.json.decode((folder / "manifest.json").read_bytes(), type=Manifest)
        if manifest.format != FORMAT:
            return None
        for name, expected in manifest.files.items():
            if os.path.basename(name) != name or digest((folder / name).read_bytes()) != expected:
                return None
        for path, expected in manifest.dependencies.items():
            if digest(Path(path).read_bytes()) != expected:
                return None
    except (OSError, msgspec.DecodeError):
        return None
    return Entry(folder, manifest)


def _is_private(path: Path) -> bool:
    """Whether nobody but the user could have written there."""
    if sys.platform == "win32":
        return True
    found = path.stat()
    return found.st_uid == os.getuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)


@contextlib.contextmanager
def building(key: str) -> Iterator[Path]:
    """Hold the lock on `key` and give a private folder to build in; it is gone afterwards.

    Raises
    ------
    AraelError
        E0804 if the cache cannot be written.
    """
    from filelock import FileLock, Timeout

    root = directory()
    try:
        root.mkdir(mode=0o700, parents=True, exist_ok=True)
        if not _is_private(root):
            raise AraelError(
                Diagnostic(
                    "E0805",
                    "the cache directory could be written by other users, so it is not used",
                    origin=str(root),
                    help=(
                        f"make it private (chmod 700 '{root}'), or choose another with "
                        "ARAEL_CACHE_DIR",
                    ),
                )
            )
        lock = FileLock(root / f"{key}.lock", timeout=300)
        lock.acquire()
    except Timeout:
        raise AraelError(
            Diagnostic(
                "E0806",
                "waited five minutes for another process that compiles the same model",
                origin=str(root / f"{key}.lock"),
                help=("end that process, or clear the cache: `arael cache clear`",),
            )
        ) from None
    except OSError as error:
        raise unwritable(root, error) from error
    try:
        folder = Path(tempfile.mkdtemp(prefix="build-", dir=root))
    except OSError as error:
        lock.release()
        raise unwritable(root, error) from error
    try:
        yield folder
    except OSError as error:
        if error.errno in _FULL:
            raise unwritable(root, error) from error
        raise
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        lock.release()
        with contextlib.suppress(OSError):
            os.unlink(root / f"{key}.lock")


def unwritable(root: Path, error: OSError) -> AraelError:
    """Tell that the cache cannot be written."""
    return AraelError(
        Diagnostic(
            "E0804",
            f"the cache of compiled models cannot be written: {error.strerror or error}",
            origin=str(root),
            help=("choose another directory with the environment variable ARAEL_CACHE_DIR",),
        )
    )


def store(
    key: str,
    built: Path,
    name: str,
    source: str,
    compiler: str,
    seconds: dict[str, float],
    dependencies: dict[str, str],
    without: str = "",
) -> Entry:
    """Move the files of the folder `built` into place as the entry of `key`."""
    root = directory()
    try:
        manifest = seal(built, key, name, source, compiler, seconds, dependencies, without)
        target = root / key
        if target.exists():
            shutil.rmtree(target)
        os.replace(built, target)
    except OSError as error:
        raise unwritable(root, error) from error
    _trim(root)
    return Entry(target, manifest)


def _trim(root: Path) -> None:
    """Remove the entries that were used longest ago, beyond `KEPT`, and builds a day old."""
    with contextlib.suppress(OSError):
        used = []
        for folder in root.iterdir():
            if folder.name.startswith("build-"):
                if folder.stat().st_mtime < time.time() - 86400:
                    shutil.rmtree(folder, ignore_errors=True)
            elif (folder / "manifest.json").exists():
                used.append((folder.stat().st_mtime, folder))
        for _, folder in sorted(used, reverse=True)[KEPT:]:
            shutil.rmtree(folder, ignore_errors=True)


def seal(
    folder: Path,
    key: str,
    name: str,
    source: str,
    compiler: str,
    seconds: dict[str, float],
    dependencies: dict[str, str],
    without: str = "",
) -> Manifest:
    """Write the manifest of a folder, which makes it an entry."""
    manifest = Manifest(
        format=FORMAT,
        name=name,
        source=source,
        arael=arael.__version__,
        made=time.time(),
        compiler=compiler,
        seconds=seconds,
        files={p.name: digest(p.read_bytes()) for p in sorted(folder.iterdir())},
        key=key,
        dependencies=dependencies,
        without=without,
    )
    (folder / "manifest.json").write_bytes(msgspec.json.encode(manifest))
    return manifest


def keep_failure(key: str, report: str) -> None:
    """Keep what a failed build said, apart from the entries."""
    with contextlib.suppress(OSError):
        folder = directory() / "failed"
        folder.mkdir(mode=0o700, exist_ok=True)
        (folder / f"{key}.log").write_text(report, encoding="utf-8")


def entries() -> list[tuple[str, Manifest, int]]:
    """Key, manifest and bytes of every entry, newest first."""
    found = []
    root = directory()
    if root.is_dir():
        for folder in root.iterdir():
            with contextlib.suppress(OSError, msgspec.DecodeError):
                manifest = msgspec.json.decode(
                    (folder / "manifest.json").read_bytes(), type=Manifest
                )
                size = sum(f.stat().st_size for f in folder.iterdir())
                found.append((folder.name, manifest, size))
    return sorted(found, key=lambda entry: -entry[1].made)


def clear() -> tuple[int, int]:
    """Remove every entry; return how many and how many bytes."""
    found = entries()
    root = directory()
    for name, _, _ in found:
        shutil.rmtree(root / name, ignore_errors=True)
    if root.is_dir():
        for leftover in (*root.glob("build-*"), root / "failed"):
            shutil.rmtree(leftover, ignore_errors=True)
        for lock in root.glob("*.lock"):
            with contextlib.suppress(OSError):
                lock.unlink()
    return len(found), sum(size for _, _, size in found)

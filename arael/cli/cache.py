"""`arael cache`: the compiled models kept on this machine."""

from __future__ import annotations

import json
import time

import click

from arael.compiler import cache


@click.group("cache", short_help="Show or clear the cache of compiled models.")
def command() -> None:
    """Show or clear the cache of compiled models.

    Its place is ARAEL_CACHE_DIR, or else the user's cache directory.
    """


@command.command("info")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def info(as_json: bool) -> None:
    """List the compiled models, newest first."""
    entries = cache.entries()
    total = sum(size for _, _, size in entries)
    if as_json:
        rows = [
            {"key": key, "name": m.name, "source": m.source, "made": m.made, "bytes": size}
            for key, m, size in entries
        ]
        found = {"directory": str(cache.directory()), "bytes": total, "entries": rows}
        click.echo(json.dumps(found))
        return
    click.echo(f"{cache.directory()}: {_count(len(entries))}, {_size(total)}")
    for key, manifest, size in entries:
        made = time.strftime("%Y-%m-%d %H:%M", time.localtime(manifest.made))
        click.echo(f"  {key[:12]}  {made}  {_size(size):>8}  {manifest.name}  {manifest.source}")


@command.command("clear")
def clear() -> None:
    """Remove every compiled model; they are compiled again when needed.

    The folder is made private to the user. Entries that another process is compiling are not
    removed.
    """
    found = cache.clear()
    click.echo(f"removed {_count(found.count)}, {_size(found.size)}, from {cache.directory()}")
    if found.busy:
        click.echo("kept entries that another process is compiling")
    for path in found.refused:
        click.echo(f"could not remove {path}: it belongs to another user, or is read-only")


def _count(entries: int) -> str:
    return f"{entries} compiled model{'' if entries == 1 else 's'}"


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e5 else f"{count / 1e3:.1f} kB"

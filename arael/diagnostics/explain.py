"""Explanations of diagnostic codes: a page of Markdown each, in ``pages/``."""

from __future__ import annotations

import re
from importlib.resources import files
from pathlib import Path

from arael.diagnostics.records import AraelError, Diagnostic
from arael.diagnostics.suggest import closest

_CODE = re.compile(r"[EW][0-9]{4}")


def codes() -> list[str]:
    """Every code that has a page, in order."""
    names = (entry.name for entry in files("arael.diagnostics").joinpath("pages").iterdir())
    found = (name.removesuffix(".md") for name in names if name.endswith(".md"))
    return sorted(code for code in found if _CODE.fullmatch(code))


def explain(code: str) -> str:
    """Text of the page of `code`; case does not matter.

    Raises
    ------
    AraelError
        If there is no such page, with similar codes.
    """
    wanted = code.strip().upper()
    known = codes()
    if wanted not in known:
        similar = closest(wanted, known, limit=3)
        hint = " or ".join(f"`{c}`" for c in similar)
        raise AraelError(
            Diagnostic(
                "E0800",
                f"there is no diagnostic `{code[:40]}`",
                origin="explain",
                help=(f"did you mean {hint}?",) if hint else (
                    "a code is a letter and four digits, as in `error[E0126]`",
                ),
            )
        )  # fmt: skip
    page = files("arael.diagnostics").joinpath("pages").joinpath(wanted + ".md")
    return page.read_text(encoding="utf-8")


def page_address(code: str) -> str | None:
    """Address of the page of `code` as a file, for editors; None if it is not a file."""
    page = files("arael.diagnostics").joinpath("pages").joinpath(f"{code}.md")
    return page.as_uri() if isinstance(page, Path) and page.is_file() else None


def title(code: str) -> str:
    """First line of the page of `code`, without its ``#``."""
    return explain(code).split("\n", 1)[0].lstrip("# ").strip()

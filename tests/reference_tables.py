"""Tables of the Python interface: names with arguments, and the first sentence of each docstring.

The pages of `docs/api/` contain them, so that they can be read without mkdocstrings.
"""

from __future__ import annotations

import inspect
import re
from importlib import import_module
from typing import Any

BEGIN, END = "<!-- names -->\n", "<!-- end of names -->\n"
_DIRECTIVE = re.compile(r"^::: (\S+)", re.MULTILINE)


def with_tables(page: str) -> str:
    """The page with the table of each section made anew, above its first directive."""
    page = re.sub(rf"{BEGIN}.*?{END}\n", "", page, flags=re.DOTALL)
    head, *sections = re.split(r"^(?=## )", page, flags=re.MULTILINE)
    return head + "".join(_section(one) for one in sections)


def _section(text: str) -> str:
    paths = _DIRECTIVE.findall(text)
    if not paths:
        return text
    rows = [row for path in paths for row in _rows(path)]
    table = "".join(f"| {name} | {summary} |\n" for name, summary in rows)
    first = text.index("::: ")
    return f"{text[:first]}{BEGIN}| name | |\n|---|---|\n{table}{END}\n{text[first:]}"


def _rows(path: str) -> list[tuple[str, str]]:
    found, name = _object(path)
    if inspect.ismodule(found):
        listed = [(n, getattr(found, n)) for n in sorted(found.__all__)]
        return [_row(n, one) for n, one in listed if getattr(one, "__doc__", None)]
    rows = [_row(name, found)]
    if inspect.isclass(found):
        members = {
            n: member
            for kind in reversed(found.__mro__)
            if kind.__module__.startswith("arael")
            for n, member in vars(kind).items()
        }
        short = name.rpartition(".")[2]
        for n, member in members.items():
            if not n.startswith("_") and _documented(member):
                rows.append(_row(f"{short}.{n}", member))
    return rows


def _documented(member: Any) -> bool:
    kinds = (property, classmethod, staticmethod)
    return (inspect.isfunction(member) or isinstance(member, kinds)) and bool(member.__doc__)


def _object(path: str) -> tuple[Any, str]:
    """The object at a dotted path, and its name from the package on."""
    module, found = path, None
    while True:
        try:
            found = import_module(module)
            break
        except ImportError:
            module = module.rpartition(".")[0]
    names = path[len(module) :].strip(".")
    for one in filter(None, names.split(".")):
        found = getattr(found, one)
    return found, path if module == "arael" else names or path


def _row(name: str, found: Any) -> tuple[str, str]:
    found = getattr(found, "__func__", found)
    summary = " ".join((inspect.getdoc(found) or "").split("\n\n")[0].split())
    return f"`{name}{_arguments(found)}`", summary.replace("|", "&#124;")


def _arguments(found: Any) -> str:
    if isinstance(found, property) or (inspect.isclass(found) and issubclass(found, Exception)):
        return ""
    try:
        parameters = inspect.signature(found).parameters.values()
    except (TypeError, ValueError):
        return ""
    if inspect.isclass(found) and len(parameters) > 8:
        return "(...)"
    shown = []
    for one in parameters:
        if one.name in ("self", "cls"):
            continue
        star = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}.get(one.kind, "")
        default = "" if one.default is one.empty else f"={one.default!r}"
        default = default if len(default) < 20 and " at 0x" not in default else "=..."
        if (
            one.kind == one.KEYWORD_ONLY
            and "*" not in shown
            and not any(name.startswith("*") for name in shown)
        ):
            shown.append("*")
        shown.append(f"{star}{one.name}{default}")
    return f"({', '.join(shown)})"

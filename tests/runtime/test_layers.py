"""Imports inside the runtime: no circles, one direction between packages, none hidden."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import arael

PACKAGE = Path(arael.__file__).parent / "runtime"
IMPORT = re.compile(r"^( *)(?:from (arael\.runtime[\w.]*) c?import (.*)|c?import (arael\.[\w.]*))")
INCLUDE = re.compile(r'^include "(.*)"$', re.MULTILINE)

#: Modules that consist of the files that they include.
GATHERING = ("compiled", "planning")

#: Packages from which nothing of the runtime's later ones is imported.
LAYERS = (
    "machine.tape", "store", "parallel", "assembly", "linear", "orthogonal", "evaluation",
    "levenberg",
)  # fmt: skip


def sources() -> dict[str, str]:
    """Text of each module below `arael.runtime`, declarations and included files and all."""
    found: dict[str, str] = {}
    gathered: set[Path] = set()
    for path in sorted(PACKAGE.rglob("*"), key=lambda path: (path.stem not in GATHERING, path)):
        if path.suffix in (".py", ".pyx", ".pxd") and path not in gathered:
            parts = path.relative_to(PACKAGE).with_suffix("").parts
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            text = path.read_text(encoding="utf-8") + "\n"
            pieces = [path.with_name(piece) for piece in INCLUDE.findall(text)]
            gathered.update(pieces)
            text += "\n".join(piece.read_text(encoding="utf-8") for piece in pieces)
            found[name] = found.get(name, "") + text + "\n"
    return found


SOURCES = sources()


def imports(text: str, indented: bool) -> set[str]:
    """Modules of the runtime that a text imports at its beginning, or also inside functions."""
    found: set[str] = set()
    checking = False
    for line in text.splitlines():
        if line and not line.startswith(" "):
            checking = line.startswith("if TYPE_CHECKING")
        match = IMPORT.match(line)
        if match is None or checking or (match[1] and not indented):
            continue
        base = (match[2] or match[4]).removeprefix("arael.runtime").strip(".")
        names = re.findall(r"\w+", match[3] or "")
        inner = {f"{base}.{name}".strip(".") for name in names} & SOURCES.keys()
        found |= inner or {base}
    return found


def circle(graph: dict[str, set[str]]) -> list[str]:
    """Return the modules of a circle, if there is one."""
    try:
        TopologicalSorter(graph).prepare()
    except ValueError as error:
        return list(error.args[1])
    return []


def test_no_module_imports_itself_by_way_of_others() -> None:
    graph = {name: imports(text, True) - {name} for name, text in SOURCES.items()}
    assert sum(map(len, graph.values())) > 200
    assert circle(graph) == []


def test_a_circle_is_found() -> None:
    graph = {name: imports(text, False) - {name} for name, text in SOURCES.items()}
    graph["layout"] = {"problem"}
    assert "layout" in circle(graph)


@pytest.mark.parametrize("layer", LAYERS)
def test_packages_import_in_one_direction(layer: str) -> None:
    later = LAYERS[LAYERS.index(layer) + 1 :]
    wrong = {
        (name, used)
        for name, text in SOURCES.items()
        if name == layer or name.startswith(layer + ".")
        for used in imports(text, True)
        if used.startswith(tuple(f"{package}." for package in later))
    }
    assert wrong == set()


def test_imports_inside_functions_are_for_start_up_time() -> None:
    silent = []
    for name, text in SOURCES.items():
        reason = checking = False
        for line in text.splitlines():
            if re.match(r"^ *(cp?def|def|class) ", line):
                reason = False
            if line and not line.startswith(" "):
                checking = line.startswith("if TYPE_CHECKING")
            reason = reason or "# Imported here for start-up time: " in line
            inside = re.match(r"^ +(from [\w.]+ c?import |import [\w.]+$)", line)
            if inside and not reason and not checking:
                silent.append(f"{name}: {line.strip()}")
    assert silent == []

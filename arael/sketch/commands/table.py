"""The table of commands: the only source of help, manual page, completion and Python methods."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from arael.sketch.commands.reading import Words
    from arael.sketch.commands.replies import Reply
    from arael.sketch.commands.session import Session

    Function = Callable[[Session, Words], Reply]

#: Groups of commands in the order of the manual, with their titles.
GROUPS = MappingProxyType(
    {
        "create": "Create geometry",
        "modify": "Change geometry",
        "constrain": "Constraints",
        "dimension": "Dimensions",
        "parameters": "Parameters",
        "select": "Selection",
        "ask": "Ask",
        "history": "History",
        "view": "View and cursor",
        "file": "Files",
        "session": "Session",
    }
)


@dataclass(frozen=True)
class Command:
    """One command.

    Attributes
    ----------
    name : its word
    group : a key of `GROUPS`
    usage : one line per form: ``add_line x1,y1 x2,y2``
    summary : what it does, in one line
    details : more of it, as Markdown; examples as fenced code
    aliases : other words for it
    keywords : words that may stand at its end, in any order
    arguments : its positional arguments as Python names; ``*name`` takes the rest, ``name=`` may
        be left out
    whole : it takes the rest of the line as it is written
    outside : it works on the history or the whole document, so not as a part of one step of undo
    function : called with the session and the words that follow
    """

    name: str
    group: str
    usage: tuple[str, ...]
    summary: str
    details: str
    aliases: tuple[str, ...]
    keywords: tuple[str, ...]
    arguments: tuple[str, ...]
    whole: bool
    outside: bool
    function: Function


_TABLE: dict[str, Command] = {}
_WORDS: dict[str, str] = {}

#: Modules of this package that hold no commands.
_CORE = frozenset({"table", "reading", "coordinates", "session", "replies", "tokens", "numbers"})


def command(
    name: str,
    *,
    group: str,
    usage: Iterable[str],
    summary: str,
    details: str = "",
    aliases: Iterable[str] = (),
    keywords: Iterable[str] = (),
    arguments: Iterable[str] = ("*words",),
    whole: bool = False,
    outside: bool = False,
) -> Callable[[Function], Function]:
    """Decorate the function of a command, which enters it into the table.

    Parameters are those of `Command`.
    """
    if group not in GROUPS:
        raise ValueError(f"no group {group!r}")

    def enter(function: Function) -> Function:
        made = Command(
            name,
            group,
            (usage,) if isinstance(usage, str) else tuple(usage),
            summary,
            details.strip("\n"),
            tuple(aliases),
            tuple(keywords),
            tuple(arguments),
            whole,
            outside,
            function,
        )
        for word in (name, *made.aliases):
            if word in _WORDS:
                raise ValueError(f"command {word!r} is in the table twice")
            _WORDS[word] = name
        _TABLE[name] = made
        return function

    return enter


@cache
def _load() -> None:
    package = import_module("arael.sketch.commands")
    for module in sorted(found.name for found in pkgutil.iter_modules(package.__path__)):
        if module not in _CORE:
            import_module(f"arael.sketch.commands.{module}")


def commands() -> MappingProxyType[str, Command]:
    """Every command by name, by group and then in the order of definition."""
    _load()
    order = list(GROUPS)
    return MappingProxyType(
        dict(sorted(_TABLE.items(), key=lambda item: order.index(item[1].group)))
    )


def find(word: str) -> Command | None:
    """The command of a word or alias, None if there is none."""
    _load()
    name = _WORDS.get(word)
    return _TABLE[name] if name is not None else None


def words() -> list[str]:
    """Every word that begins a command, aliases included."""
    _load()
    return sorted(_WORDS)

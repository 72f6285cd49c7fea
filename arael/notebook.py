"""``%%arael``: a model in a notebook cell. Load with ``%load_ext arael.notebook``."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import AraelError
from arael.loading import loads

OPTIONS = "--precision f32|f64, --root NAME, --interpret"


def load_ipython_extension(shell: Any) -> None:
    """Register the magic; IPython calls this."""

    def arael(line: str, cell: str) -> Any:
        """Load the model in the cell as a class with the name of its root.

        Options: --precision f32|f64, --root NAME, --interpret. A name assigns the class to it:
        ``%%arael Slam``.
        """
        name, options = _read(line)
        try:
            found = loads(cell, name="cell.arael", **options)
        except AraelError as error:
            print(error)
            return None
        shell.user_ns[name or found.__name__] = found
        return None

    shell.register_magic_function(arael, "cell", "arael")


def _read(line: str) -> tuple[str, dict[str, Any]]:
    """Name and options of a magic's line; UsageError for others."""
    # imported here: start-up time
    from IPython.core.error import UsageError

    words, name = line.split(), ""
    options: dict[str, Any] = {}
    while words:
        word = words.pop(0)
        if word in ("--precision", "--root") and words:
            options[word[2:]] = words.pop(0)
        elif word == "--interpret":
            options["interpret"] = True
        elif word.isidentifier() and not name:
            name = word
        else:
            raise UsageError(f"unknown option {word!r}; there are {OPTIONS}, and a name")
    return name, options

"""Write the grammars of editors: ``python -m arael.highlighting`` in a checkout."""

from __future__ import annotations

from pathlib import Path

from arael.highlighting.textmate import grammar
from arael.highlighting.vim import syntax


def files() -> dict[str, str]:
    """The generated files by their path in the repository."""
    return {
        "editors/vscode/syntaxes/arael.tmLanguage.json": grammar(),
        "editors/vim/syntax/arael.vim": syntax(),
    }


def main() -> None:
    """Write the files below the checkout that holds this package."""
    checkout = Path(__file__).parents[2]
    for name, text in files().items():
        path = checkout / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        print(f"wrote {name}")


if __name__ == "__main__":
    main()

"""The table for users of the Rust framework: every form in it is executed, or is a real command."""

from __future__ import annotations

import re
from pathlib import Path

import click
import pytest

from arael.check.builtins import FUNCTIONS
from arael.cli.main import command

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "from_rust.md").read_text(encoding="utf-8")

# Forms that another install command, another test or the language itself vouches for.
ELSEWHERE = {
    'pip install "arael[cholmod]"': "pyproject.toml has the extra; CI installs it",
    'solver="cholmod"': "tests/runtime/linear runs it where it is installed",
}


def squeezed(text: str) -> str:
    return re.sub(r"\s+", " ", text)


CODE = squeezed("\n".join(re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)))


def rows() -> list[tuple[str, str]]:
    found = []
    for line in PAGE.splitlines():
        cells = re.split(r"(?<!\\)\|", line.strip())[1:-1]
        if len(cells) == 2 and not set(line) <= set("|-") and cells[0].strip() != "there":
            found.append((cells[0].replace(r"\|", "|"), cells[1].replace(r"\|", "|")))
    return found


def forms() -> list[str]:
    return sorted({span for _, here in rows() for span in re.findall(r"`([^`]+)`", here)})


def is_command(form: str) -> bool:
    """Whether `form` is a command of `arael` with options that it has."""
    words = form.split()
    group = click.Context(command)
    found: click.Command | None = command
    for word in words[1:]:
        if word.startswith("-"):
            assert found is not None
            options = {o for p in found.params for o in (*p.opts, *p.secondary_opts)}
            if word not in options:
                return False
        elif isinstance(found, click.Group):
            found = found.get_command(group, word)
            if found is None:
                return False
    return True


def test_the_table_is_read() -> None:
    assert len(rows()) > 120 and len(forms()) > 200


@pytest.mark.parametrize("form", forms())
def test_every_form_is_executed_or_a_command(form: str) -> None:
    if form.startswith("arael "):
        assert is_command(form)
    elif form.startswith("python examples/") or form == "examples/":
        assert (ROOT / form.removeprefix("python ").split()[0]).exists()
    elif form not in ELSEWHERE and form not in FUNCTIONS:
        assert squeezed(form) in CODE


def test_every_example_of_the_framework_is_here() -> None:
    listed = re.search(r"^(`bench_band`.*?) run by", PAGE, re.DOTALL | re.MULTILINE)
    assert listed is not None
    names = re.findall(r"`(\w+)`", listed[1])
    assert len(names) == 15
    for name in names:
        assert (ROOT / "examples" / name / f"{name}.py").exists(), name

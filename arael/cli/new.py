"""`arael new`: a small model and data to start from."""

from __future__ import annotations

import re
from pathlib import Path

import click

from arael.diagnostics.records import AraelError, Diagnostic
from arael.io.files import write_whole

MODEL = """\
# A line through points with outliers. Solve it with:
#     arael solve {name}.json

struct Point {{ x: real; y: real }}

root {root} : f64 {{
    param slope:  real
    param offset: real
    points: list of Point
    sigma:  real = 0.1                      # standard deviation of a point

    constraint line_prior {{
        1e-3 * [slope, offset]
    }}

    fit points as p loss cauchy(2) {{        # a wrong point has little influence
        (slope * p.x + offset - p.y) / sigma
    }}
}}
"""

DATA = """\
{
  "slope": 1.0,
  "offset": 0.0,
  "points": [
    {"x": 0.0, "y": 1.02},
    {"x": 1.0, "y": 2.95},
    {"x": 2.0, "y": 5.01},
    {"x": 3.0, "y": 19.0},
    {"x": 4.0, "y": 9.03}
  ]
}
"""


@click.command("new", short_help="Write a small model and data to start from.")
@click.argument("name")
def command(name: str) -> None:
    """Write NAME.arael and NAME.json here: a robust line fit as a starting point."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,60}", name):
        raise click.BadParameter("expected letters, digits and _, beginning with a letter")
    root = "".join(part.capitalize() for part in name.split("_"))
    texts = {f"{name}.arael": MODEL.format(name=name, root=root), f"{name}.json": DATA}
    for file in texts:
        if Path(file).exists():
            raise AraelError(
                Diagnostic("E0854", "the file exists already", origin=file, help=("name another",))
            )
    _write_all(texts)
    click.echo(f"wrote {name}.arael and {name}.json; solve with")
    click.echo(f"  arael solve {name}.json")


def _write_all(texts: dict[str, str]) -> None:
    """Write all files or none."""
    written: list[str] = []
    try:
        for file, text in texts.items():
            content = text.encode()
            write_whole(file, lambda out, content=content: out.write(content))  # type: ignore[misc]
            written.append(file)
    except BaseException:
        for file in written:
            Path(file).unlink(missing_ok=True)
        raise

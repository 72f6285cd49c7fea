"""A bracket drawn by a script, resized by two parameters, and written as DXF, SVG and PNG."""

from __future__ import annotations

import argparse
from pathlib import Path

from arael import AraelError
from arael.sketch import Sketch

HERE = Path(__file__).parent


def main() -> None:
    """Draw the bracket twice and report what became of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path(), help="folder of the drawings")
    folder = parser.parse_args().output

    sketch = Sketch()
    sketch.run((HERE / "bracket.cmd").read_text(encoding="utf-8"), "bracket.cmd")
    report("drawn", sketch)

    sketch.param("width", 120)
    sketch.param("height", 60)
    report("resized", sketch)

    # A second value for a length that is known is refused, with what contradicts it.
    try:
        sketch.run("hdistance bottom.p1 bore.center 90")
    except AraelError as error:
        print(error.diagnostics[0].message)

    for name in ("bracket.svg", "bracket.png", "bracket.dxf"):
        try:
            sketch.export(folder / name)
            print("written:", name)
        except AraelError as error:  # DXF and PNG need optional parts
            print(f"{name}: {error.diagnostics[0].message}")


def report(what: str, sketch: Sketch) -> None:
    """Sizes, and how much of the sketch is free."""
    bore, slot = sketch["bore"], sketch["upper"]
    freedoms = sketch.dof()["freedoms"]
    print(
        f"{what}: {len(sketch)} entities, {freedoms} degrees of freedom, bore of radius "
        f"{bore.radius:g} at ({bore.center.x:g}, {bore.center.y:g}), slot of length {slot.length:g}"
    )


if __name__ == "__main__":
    main()

"""`export` and `import` end to end: commands, files, and back."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.document.saved import to_json
from arael.sketch.exchange import Imported, read
from arael.sketch.sketch import Sketch
from tests.optional import needs

SCRIPT = (
    "add_rect 0,0 40,30 hv",
    "add_line 0,30 20,45 40,30",
    "add_circle 15,12 6",
    "add_arc 60,0 60,30 75,15",
    "add_line 40,0 60,0",
    "length L0 40",
    "radius A0 6",
)


@pytest.fixture(scope="module")
def house() -> Sketch:
    sketch = Sketch()
    for line in SCRIPT:
        sketch.run(line)
    return sketch


@needs("ezdxf")
def test_a_sketch_goes_through_dxf_unchanged(house: Sketch, tmp_path: Path) -> None:
    house.export(tmp_path / "house.dxf")
    again = read(tmp_path / "house.dxf")
    assert not isinstance(again, Imported)
    assert to_json(again) == to_json(house.document)


def test_every_suggestion_is_a_command_that_is_taken(house: Sketch, tmp_path: Path) -> None:
    """None is redundant with another, and none contradicts the geometry."""
    house.export(tmp_path / "house.svg")
    other = Sketch()
    other.import_(tmp_path / "house.svg")
    found = read(tmp_path / "house.svg")
    assert isinstance(found, Imported) and len(found.suggestions) > 12
    for one in found.suggestions:
        other.run(str(one))
    assert len(other.document.constraints) == len(found.suggestions)


def test_what_was_left_out_is_in_the_answer(tmp_path: Path) -> None:
    path = tmp_path / "note.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg"><text>a</text><path d="M0 0h9"/></svg>'
    )
    sketch = Sketch()
    sketch.session.folder = tmp_path
    (reply,) = sketch.run("import note.svg")
    assert reply.text.count("1 `text` element left out") == 1
    assert "found relations, which are not applied: 1 horizontal" in reply.text


def test_a_damaged_file_changes_nothing(house: Sketch, tmp_path: Path) -> None:
    before = to_json(house.document)
    (tmp_path / "bad.svg").write_text("<svg><path")
    with pytest.raises(AraelError) as caught:
        house.import_(tmp_path / "bad.svg")
    assert caught.value.diagnostics[0].code == "E1302"
    assert to_json(house.document) == before


def test_notebooks_show_the_drawing(house: Sketch) -> None:
    svg = house._repr_svg_()
    assert svg.startswith("<svg") and 'data-name="L0"' in svg

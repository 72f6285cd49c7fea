"""Another unit for a part: converted, its size stays; relabelled, its numbers do."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.exchange.files import write

PART = """
add_rect 0,0 40,20 hv
param w 40
param t 30 deg
param gap L0.length / 4
length L0 w
length L1 w / 2 + 1
lock L0.p1
add_circle 8,8 2.5
radius A0 2.5
distance L0.p1 A0.center >= 3
add_line 0,30 10,35
length L4 12 mm
xangle L4 t
dim_pos d0 offset 6
add_ellipse 60,10 9 4 10
"""


def drawn() -> Session:
    session = Session()
    session.run(PART)
    return session


def numbers(session: Session) -> dict[str, list[float]]:
    document = session.document
    return {name: document.numbers_of(name).tolist() for name in document.entities}


def test_a_converted_part_keeps_its_size(tmp_path: Path) -> None:
    session = drawn()
    document = session.document
    before, dims = numbers(session), {n: d.value for n, d in document.dimensions.items()}
    write(document, tmp_path / "mm.svg")
    session.run("settings unit in convert")
    assert document.unit == "in"
    for name, entity in document.entities.items():
        angles = {4} if entity.kind == "ellipse" else set()
        for k, (old, new) in enumerate(zip(before[name], numbers(session)[name], strict=True)):
            assert new == pytest.approx(old if k in angles else old / 25.4, abs=1e-9)
    for name, old in dims.items():
        new = document.dimensions[name].value
        if old is None or new is None:
            continue
        angle = document.dimensions[name].kind == "xangle"
        assert new.number == pytest.approx(old.number / (1.0 if angle else 25.4))
    assert document.dimensions["d0"].value.text == "(w) * 1 mm"  # type: ignore[union-attr]
    assert document.dimensions["d0"].offset == pytest.approx(6 / 25.4)
    assert document.parameters["w"].amount.number == 40.0
    assert document.parameters["gap"].amount.number == pytest.approx(10 / 25.4)
    write(document, tmp_path / "in.svg")
    old_size, new_size = (_size(tmp_path / f"{one}.svg") for one in ("mm", "in"))
    assert new_size == pytest.approx(old_size, rel=1e-6)
    session.run("param w 50")  # what reads it follows in millimetres
    assert document.numbers_of("L0")[2] == pytest.approx(50 / 25.4)
    session.run("undo 2")
    assert document.unit == "mm" and numbers(session) == before


def _size(path: Path) -> list[float]:
    text = path.read_text()
    return [float(text.split(f'{side}="')[1].split("mm")[0]) for side in ("width", "height")]


def test_a_relabelled_part_keeps_its_numbers() -> None:
    session = drawn()
    session.run("length L4 12")
    before = numbers(session)
    session.run("settings unit in relabel")
    assert session.document.unit == "in"
    for name, old in before.items():
        assert numbers(session)[name] == pytest.approx(old)


def test_what_cannot_be_converted_is_named_and_nothing_changes() -> None:
    session = drawn()
    session.run("param sum L0.length + 5")
    before = numbers(session)
    with pytest.raises(AraelError, match=r"E1261.*`sum`.*\n?") as caught:
        session.run("settings unit in convert")
    assert "5 mm" in str(caught.value)
    assert session.document.unit == "mm" and numbers(session) == before

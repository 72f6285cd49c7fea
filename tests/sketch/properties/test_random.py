"""Random sketches: edited, refused, undone, redone, perturbed, dragged."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.properties.generator import Generator, perform, snapshot

SEEDS = [1, 2, 3, 4]
MANY = range(100, 110)
MORE = range(100, 160)


def run(session: Session, line: str) -> bool:
    """Run a line; False if it was refused, and then nothing is changed."""
    before, place = snapshot(session.document), session.document.history.position
    try:
        perform(session, line)
    except AraelError:
        assert snapshot(session.document) == before, line
        assert session.document.history.position == place, line
        return False
    return True


def edited(seed: int, steps: int) -> None:
    """A random life of a sketch, every state of which is found again."""
    session = Session()
    document, layout = session.document, session.editor.layout
    generator = Generator(session, seed)
    states = {0: snapshot(document)}
    done = 0
    for _ in range(steps):
        line = generator.line()
        place = document.history.position
        if not run(session, line):
            continue
        done += 1
        layout.check()
        if document.history.position == place:
            assert snapshot(document) == states[place], line
            continue
        states[document.history.position] = snapshot(document)
        if generator.random.random() < 0.3:
            session.run("undo")
            assert snapshot(document) == states[place], f"undo {line}"
            layout.check()
            if generator.random.random() < 0.7:
                session.run("redo")
                assert snapshot(document) == states[place + 1], f"redo {line}"
                layout.check()
    assert done > steps // 3
    last = document.history.position
    for place in range(last - 1, -1, -1):
        session.run("undo")
        assert snapshot(document) == states[place]
        if place % 10 == 0:
            layout.check()
    assert not document.entities
    for place in range(1, last + 1):
        session.run("redo")
        assert snapshot(document) == states[place]
    layout.check()


@pytest.mark.sweep(4)
@pytest.mark.parametrize("seed", SEEDS)
def test_every_state_is_found_again_bit_by_bit(seed: int) -> None:
    edited(seed, 60)


@pytest.mark.slow
@pytest.mark.parametrize("seed", MANY)
def test_every_state_of_many_sketches_is_found_again(seed: int) -> None:
    edited(seed, 120)


def random_sketch(seed: int, steps: int = 40) -> Session:
    """A sketch that random commands made."""
    session = Session()
    generator = Generator(session, seed)
    for _ in range(steps):
        run(session, generator.line())
    return session


def worst(session: Session) -> float:
    """Largest residual of the sketch, relative to its size."""
    system = session.editor.layout.linearisation()
    return float(np.abs(system.residuals).max(initial=0.0)) / session.editor.layout.size


def perturbed_and_dragged(seed: int) -> None:
    session = random_sketch(seed)
    document, editor = session.document, session.editor
    random = np.random.default_rng(seed)
    assert worst(session) < 1e-8
    start = snapshot(document)
    # A satisfied sketch does not move.
    assert editor.solve().moved == ()
    assert snapshot(document) == start
    # Perturbed, it is solved again, or it is as it was.
    free = np.flatnonzero(editor.layout.column_of >= 0)
    for size in (1e-6, 1e-3):
        before = snapshot(document)
        shift = random.uniform(-size, size, len(free))
        try:
            with document.transaction("perturb"):
                document.set_values(free, document.values[free] + shift)
                editor.solve()
        except AraelError:
            assert snapshot(document) == before
        else:
            assert worst(session) < 1e-8
    editor.layout.check()
    # A drag holds all equations in every frame, and is one step.
    points = Generator(session, seed).points()
    handle = points[int(random.integers(len(points)))]
    before, position = snapshot(document), document.history.position
    with editor.dragging([handle]) as drag:
        for k in range(1, 6):
            drag.by(0.3 * k, -0.2 * k)
            assert worst(session) < 1e-8
    editor.layout.check()
    assert document.history.position <= position + 1
    if document.history.position > position:
        document.undo()
    assert snapshot(document) == before
    while document.undo() is not None:
        pass
    assert not document.entities
    assert len(document.values) == 0


@pytest.mark.parametrize("seed", SEEDS)
def test_perturbed_and_dragged_sketches_keep_their_equations(seed: int) -> None:
    perturbed_and_dragged(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", MORE)
def test_many_perturbed_and_dragged_sketches_keep_their_equations(seed: int) -> None:
    perturbed_and_dragged(seed)

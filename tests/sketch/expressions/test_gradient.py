"""Expressions over geometry where a derivative does not exist."""

from __future__ import annotations

import numpy as np
import pytest

from arael.sketch.commands.session import Session


def test_a_distance_that_is_zero_has_a_derivative() -> None:
    session = Session()
    session.run("add_point 0,0; add_point 5,0; add_point 5,4")
    session.run("distance P0 P1 derived; distance P0 P2 d0 force")
    session.run("drag P1 0,0; coincident P0 P1")
    assert session.editor.measure("distance", ("P0", "P2")) == pytest.approx(0.0, abs=1e-9)
    assert session.run("dof")[0].data["freedoms"] >= 2  # it can be judged


def test_an_expression_without_a_derivative_is_judged_as_a_constant() -> None:
    session = Session()
    session.run("add_point 5,0; add_line 8,8 9,9; length L0 sqrt(P0.x) force")
    with session.document.transaction("where the square root begins"):
        session.document.set_values([0], [0.0])
    assert session.editor.layout.linearisation().entries.size
    assert np.isfinite(session.editor.layout.linearisation().entries).all()

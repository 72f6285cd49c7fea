"""States of entities: retraction, caches and their derivatives against differences."""

import numpy as np
import pytest

from arael.compiler import compiler
from arael.compiler.entities import StateModel, model_state
from arael.diagnostics.records import Findings, Source
from arael.syntax.parser import parse
from tests.oracle import evaluate

TEXT = """
root Everything {
    param a: real
    param v: vec<5>
    param e: euler
    param r: rotation
    param q: quaternion
    param h: angle
    constraint c {
        [a, v[0], e.rotation_matrix()[0, 0], r.rotation_matrix()[0, 1], q.w, h]
    }
}
"""


@pytest.fixture(scope="module")
def state() -> StateModel:
    """State of an entity with a parameter of every kind."""
    model = compiler.types(parse(Source("r.arael", TEXT)), Findings())
    (site,) = model.entities
    return model_state(site)


def stored_value(rng: np.random.Generator) -> np.ndarray:
    """A random point: quaternions are unit."""
    parts = [rng.normal(size=1), rng.normal(size=5), rng.uniform(-1, 1, 3)]
    for _ in range(2):
        q = rng.normal(size=4)
        parts.append(q / np.linalg.norm(q))
    return np.concatenate([*parts, rng.uniform(-2, 2, 1)])


def moved(state: StateModel, stored: np.ndarray, step: np.ndarray) -> np.ndarray:
    tape = state.entity.refresh
    values = evaluate(tape, [*stored, *step])
    return np.array([float(values[n]) for n in tape.outputs])


def test_a_step_of_zero_keeps_the_value(state: StateModel) -> None:
    stored = stored_value(np.random.default_rng(1))
    found = moved(state, stored, np.zeros(state.entity.tangent))
    np.testing.assert_allclose(found[: state.entity.stored], stored, atol=1e-15)


@pytest.mark.slow
def test_tangents_agree_with_central_differences(state: StateModel) -> None:
    rng = np.random.default_rng(2)
    n, h = state.entity.tangent, 1e-6
    for _ in range(5):
        stored = stored_value(rng)
        here = moved(state, stored, np.zeros(n))
        inputs = list(state.graph.inputs)
        for offset, row in enumerate(state.tangents):
            if not row and offset >= state.entity.stored:
                continue
            nodes = list(row.values())
            tape = state.graph.tape(nodes, inputs=inputs)
            values = evaluate(tape, [here[o] for o in inputs])  # type: ignore[index]
            derived = np.zeros(n)
            derived[list(row)] = [float(values[o]) for o in tape.outputs]
            for k in range(n):
                step = np.zeros(n)
                step[k] = h
                ahead, behind = moved(state, stored, step), moved(state, stored, -step)
                expected = (ahead[offset] - behind[offset]) / (2 * h)
                assert derived[k] == pytest.approx(expected, abs=1e-8), (state.names[offset], k)


def test_rotation_caches_are_rotations(state: StateModel) -> None:
    here = moved(state, stored_value(np.random.default_rng(3)), np.full(state.entity.tangent, 0.3))
    for column in ("e", "r", "q"):
        matrix = here[list(state.caches[column]["R"])].reshape(3, 3)
        np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-14)
        assert np.linalg.det(matrix) == pytest.approx(1)


def test_names_are_the_users(state: StateModel) -> None:
    assert state.names[0] == "a"
    assert "e.R[0,2]" in state.names
    assert state.entity.tangent_names[:7] == ("a", "v[0]", "v[1]", "v[2]", "v[3]", "v[4]", "e.x")

"""Parameter types: retractions, tangents, caches."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from arael.manifolds.parameters import PARAMETERS, ParameterType, parameter_type
from arael.symbolic.graph import Graph
from tests.symbolic.programs import inputs, run

KINDS = [*PARAMETERS, "vec2", "vec3", "vec7"]
angles = st.floats(-3.0, 3.0, allow_subnormal=False)


def stored_value(kind: ParameterType, seed: int) -> np.ndarray:
    value = np.random.default_rng(seed).normal(size=kind.storage)
    unit = {"rotation": slice(4), "quaternion": slice(4), "direction": slice(3)}
    part = unit.get(kind.name, slice(3, 7) if kind.storage in (7, 8) and kind.parts else slice(0))
    value[part] /= np.linalg.norm(value[part])
    value[7:] = np.exp(value[7:]) if kind.name == "similarity" else value[7:]
    return value


def retract(kind: ParameterType, stored: object, delta: object) -> np.ndarray:
    g = Graph()
    s, d = inputs(g, kind.storage, "s"), inputs(g, kind.tangent_width, "d")
    return run(g, kind.retract(g, s, d), [*stored, *delta])  # type: ignore[misc]


@pytest.mark.parametrize("name", KINDS)
def test_no_step_changes_nothing(name: str) -> None:
    kind = parameter_type(name)
    stored = stored_value(kind, 1)
    found = retract(kind, stored, np.zeros(kind.tangent_width))
    np.testing.assert_allclose(found, stored, rtol=1e-15)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", KINDS)
def test_tangents_against_differences_of_the_retraction(name: str, seed: int) -> None:
    kind = parameter_type(name)
    stored, width = stored_value(kind, seed), kind.tangent_width
    g = Graph()
    s, d = inputs(g, kind.storage, "s"), inputs(g, width, "d")
    moved = kind.retract(g, s, d)
    caches = kind.caches(g, moved)
    read = kind.cache_tangents(g, s, kind.caches(g, s))
    nodes = [*moved, *(node for name in read for node in caches[name])]
    step = 1e-6
    differences = np.array(
        [
            (run(g, nodes, [*stored, *h]) - run(g, nodes, [*stored, *-h])) / (2 * step)
            for h in np.eye(width) * step
        ]
    ).T
    here = kind.caches(g, s)
    of_caches = kind.cache_tangents(g, s, here)
    assert list(here) == [name for name, _ in kind.cache_names]
    assert [len(v) for v in here.values()] == [n for _, n in kind.cache_names]
    tangents = [*kind.tangent(g, s, here), *(t for cache in of_caches.values() for t in cache)]
    zero = g.const(0.0)
    flat = [entries.get(k, zero) for entries in tangents for k in range(width)]
    found = run(g, flat, [*stored, *np.zeros(width)]).reshape(-1, width)
    np.testing.assert_allclose(found, differences, atol=1e-9)


@pytest.mark.parametrize("name", KINDS)
def test_cache_tangents_need_nothing_but_caches_and_storage(name: str) -> None:
    kind = parameter_type(name)
    g = Graph()
    s = inputs(g, kind.storage, "s")
    caches = {cache: inputs(g, n, cache) for cache, n in kind.cache_names}
    for entries in kind.cache_tangents(g, s, caches).values():
        for node in (n for entry in entries for n in entry.values()):
            names = {g.ops[n] for n in g.live([node])}
            assert names <= {"input", "neg", "mul", "add", "sub"}


@settings(max_examples=50, deadline=None)
@given(st.tuples(angles, angles, angles), st.integers(0, 50))
def test_rotations_are_composed_on_the_right(delta: tuple[float, ...], seed: int) -> None:
    for name, step in (
        ("rotation", Rotation.from_euler("ZYX", delta[::-1])),
        ("quaternion", Rotation.from_rotvec(delta)),
    ):
        kind = parameter_type(name)
        stored = stored_value(kind, seed)
        found = retract(kind, stored, delta)
        assert np.linalg.norm(found) == pytest.approx(1.0, abs=1e-15)
        expected = Rotation.from_quat(np.roll(stored, -1)) * step
        g = Graph()
        r = run(g, kind.caches(g, inputs(g, 4))["R"], found).reshape(3, 3)
        np.testing.assert_allclose(r, expected.as_matrix(), atol=1e-13)
        np.testing.assert_allclose(r @ r.T, np.eye(3), atol=1e-14)


@settings(max_examples=30, deadline=None)
@given(st.tuples(angles, angles, angles), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_steps_about_one_axis_add_up(axis: tuple[float, ...], s: float, t: float) -> None:
    kind = parameter_type("quaternion")
    v = np.array(axis)
    there = retract(kind, retract(kind, kind.neutral, s * v), t * v)
    at_once = retract(kind, kind.neutral, (s + t) * v)
    np.testing.assert_allclose(abs(there @ at_once), 1.0, atol=1e-13)


def test_tiny_steps_are_not_lost_and_drift_is_removed() -> None:
    kind = parameter_type("quaternion")
    found = retract(kind, kind.neutral, [1e-10, 0, 0])
    assert found[1] == pytest.approx(0.5e-10, rel=1e-14)
    drifted = np.array([1.001, 0.0, 0.0, 0.0])
    assert np.linalg.norm(retract(kind, drifted, [0.1, 0, 0])) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("stored", [3.0, -3.0, 0.0])
@pytest.mark.parametrize("delta", [0.5, -0.5, 7.0, -20.0])
def test_angles_wrap(stored: float, delta: float) -> None:
    (found,) = retract(parameter_type("angle"), [stored], [delta])
    assert -np.pi < found <= np.pi
    turns = (stored + delta - found) / (2 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-14)


def test_names() -> None:
    assert parameter_type("vec5").storage == 5
    assert parameter_type("euler").flat and not parameter_type("rotation").flat
    for name in ("vec", "vec0", "vec65", "vec999", "vec1000", "vec٣", "vec3\n", "matrix", ""):
        with pytest.raises(KeyError):
            parameter_type(name)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", KINDS)
def test_local_coordinates_invert_the_retraction(name: str, seed: int) -> None:
    kind = parameter_type(name)
    base, width = stored_value(kind, seed), kind.tangent_width
    for size in (0.0, 1e-9, 0.4):
        delta = size * np.random.default_rng(seed + 7).normal(size=width)
        g = Graph()
        b, s = inputs(g, kind.storage, "b"), inputs(g, kind.storage, "s")
        found = run(g, kind.local(g, b, s), [*base, *retract(kind, base, delta)])
        np.testing.assert_allclose(found, delta, rtol=1e-9, atol=2e-15)

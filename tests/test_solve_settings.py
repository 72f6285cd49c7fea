"""Settings and options of a solve: numbers of NumPy, wrong types, the same settings again."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import arael
from arael.config import LmConfig
from arael.diagnostics.records import AraelError
from arael.solving import solve
from tests.test_solving import chain, code_of, line

# --- numbers of NumPy as settings ------------------------------------------------------------


@pytest.mark.parametrize("kind", [np.int64, np.int32, np.uint8, np.array])
def test_whole_numbers_of_numpy_are_settings(kind):
    counts = {"max_iters": 5, "min_iters": 2, "patience": 1, "retry_budget": 3, "num_threads": 1}
    config = LmConfig(**{name: kind(value) for name, value in counts.items()})
    config.validate()
    assert {name: getattr(config, name) for name in counts} == counts
    assert all(type(getattr(config, name)) is int for name in counts)
    assert len(solve(line(), max_iters=kind(2), min_iters=kind(9)).history) == 2


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.float16])
def test_numbers_of_numpy_are_settings(kind):
    numbers = {"abs_precision": 0.5, "lambda_floor": 0.25, "time_limit": 8.0, "min_diagonal": 1.0}
    config = LmConfig.of(**{name: kind(value) for name, value in numbers.items()})
    assert {name: getattr(config, name) for name in numbers} == numbers
    assert all(type(getattr(config, name)) is float for name in numbers)
    assert LmConfig.of(verbose=np.bool_(True)).verbose is True
    assert LmConfig.of(lambda_ceiling=kind(4.0)).lambda_ceiling == 4.0


@pytest.mark.parametrize("value", [np.float64(5), 5.0, np.array([5]), "5", True, np.bool_(True)])
def test_what_is_no_whole_number_is_refused(value):
    with pytest.raises(AraelError, match="`max_iters` is"):
        LmConfig.of(max_iters=value)


def test_an_array_as_damping_is_refused():
    with pytest.raises(AraelError, match="`damping` is"):
        LmConfig.of(damping=np.ones(3))


# --- solvers and options of the wrong type ---------------------------------------------------


@pytest.mark.parametrize("solver", [3, None, ["dense"], b"dense", 1.5])
def test_a_solver_that_is_no_name_is_refused(solver):
    with pytest.raises(AraelError, match="there is no linear solver") as caught:
        solve(line(), solver=solver)
    assert code_of(caught) == "E0840"
    assert "schur_pcg" in caught.value.diagnostics[0].notes[0]


@pytest.mark.parametrize(
    ("solver", "options"),
    [
        ("sparse", 3),
        ("sparse", [("ordering", "natural")]),
        ("sparse", {3: 1}),
        ("sparse", {"ordering": 3}),
        ("sparse", {"ordering": None}),
        ("sparse", {"ordering": np.arange(3)}),
        ("band", {"half_bandwidth": "x"}),
        ("band", {"block_half_bandwidth": 1.5}),
        ("schur", {"eliminate": 3}),
        ("schur", {"eliminate": None}),
        ("schur", {"eliminate": [1.5]}),
        ("schur", {"eliminate": [0, "nodes"]}),
        ("schur", {"reduced": 3}),
        ("schur_pcg", {"tolerance": "x"}),
        ("schur_pcg", {"floor": None}),
        ("schur_pcg", {"iterations": "x"}),
        ("schur_pcg", {"iterations": 2.5}),
        ("schur_pcg", {"formed": np.ones(3)}),
        ("schur_pcg", {"preconditioner": ["jacobi"]}),
    ],
)
def test_options_of_the_wrong_type_are_refused_by_name(solver, options):
    with pytest.raises(AraelError) as caught:
        solve(chain(), solver=solver, solver_options=options)
    assert code_of(caught) == "E0842"
    name = next(iter(options)) if isinstance(options, dict) else "solver_options"
    assert (name if isinstance(name, str) else "solver_options") in str(caught.value)


def test_options_may_be_numbers_of_numpy():
    assert solve(
        chain(), solver="band", solver_options={"block_half_bandwidth": np.int64(11)}
    ).converged
    assert solve(chain(), solver="schur", solver_options={"eliminate": np.array([0, 5])}).converged


def test_the_same_settings_give_the_same_configuration_and_bad_ones_never_pass() -> None:
    base = arael.LmConfig()
    assert base.with_(max_iters=1) is base.with_(max_iters=1)
    assert base.with_(max_iters=1) is not base.with_(max_iters=2)
    for bad in (1.0, True):  # equal to 1, and no whole number of attempts
        with pytest.raises(arael.AraelError, match="max_iters"):
            base.with_(max_iters=bad)

    def observe(record: object) -> None: ...

    assert base.with_(observer=observe) is not base.with_(observer=observe)


def test_a_configuration_with_an_observer_is_checked_and_known_as_the_one_without() -> None:
    def first(record: object) -> None:
        """Observe."""

    def second(record: object) -> None:
        """Observe."""

    base = LmConfig.of(rel_precision=1e-7)
    found = base.with_(max_iters=7, observer=first)
    assert found == dataclasses.replace(base, max_iters=7, observer=first)
    assert base.observer is None and base.with_(max_iters=7).observer is None
    assert found.with_(max_iters=8).observer is first  # nothing made without it is taken
    assert found.with_(observer=second).observer is second
    assert found.with_(observer=None).observer is None
    for settings in ({"max_iters": -1}, {"max_iter": 3}):
        with pytest.raises(arael.AraelError) as caught:
            LmConfig.of(observer=first, **settings)
        assert code_of(caught) == "E1010"
    with pytest.raises(arael.AraelError) as caught:
        LmConfig.of(observer=3)
    assert code_of(caught) == "E1010"
    with pytest.raises(arael.AraelError) as caught:  # not checked before
        LmConfig(max_iters=-1).with_(observer=first)
    assert code_of(caught) == "E1010"

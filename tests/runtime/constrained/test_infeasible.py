"""Problems that nothing solves: the status, the violation, and what cannot hold together."""

from __future__ import annotations

import pytest

import arael
from arael.runtime.failures import SolveError

MODEL = """
struct P {
    param x: vec2
    far: real
    constraint near { x - [1, 2] }
    require out { norm(x) >= far }
    require within { norm(x) <= 2 }
    require left { x.x <= 0 }
}
root R { ps: list of P }
"""


def test_a_minimal_set_is_named() -> None:
    loaded = arael.loads(MODEL, interpret=True)
    model = loaded(ps=[{"x": [1, 0.1], "far": 1}, {"x": [0.1, 2], "far": 3}])
    result = model.solve()
    assert result.status == "infeasible"
    assert not result.converged
    assert result.conflict == ("P.out at ps[1]", "P.within at ps[1]")
    assert result.violation > 0.1
    assert "cannot hold together" in str(result)


@pytest.mark.parametrize("left_out", ["out", "within"])
def test_without_any_one_of_them_the_others_hold(left_out: str) -> None:
    text = MODEL.replace(f"require {left_out}", f"require {left_out} when false")
    model = arael.loads(text, interpret=True)(ps=[{"x": [0.1, 2], "far": 3}])
    assert model.solve().converged


def test_a_bound_may_be_part_of_it() -> None:
    model = arael.loads(
        """
root R {
    param z: real in 0 ..
    param w: real
    constraint near { [z, w] }
    require below { z + w == -2 }
    require same { w == z }
}
""",
        interpret=True,
    )(z=1, w=0)
    result = model.solve()
    assert result.status == "infeasible"
    assert set(result.conflict) == {"R.below", "R.same", "z >= 0"}
    assert model.z.value >= 0


def test_curved_rows_that_contradict_each_other_are_found_at_once() -> None:
    model = arael.loads(
        """
root R {
    param x: vec2
    constraint near { x - [3, 4] }
    require circle { norm(x) == 2 }
    require right { x.x >= 3 }
}
""",
        interpret=True,
    )(x=[1, 0.1])
    result = model.solve()
    assert result.status == "infeasible"
    assert result.conflict == ("R.circle", "R.right")
    assert result.iterations < 60
    assert model.x.value == pytest.approx([2.5, 0], abs=1e-3)


def test_what_no_parameter_changes_is_checked_first() -> None:
    model = arael.loads(
        """
root R {
    param x: real
    least: real
    constraint near { x }
    require sound { least >= 2 }
}
""",
        interpret=True,
    )(x=0, least=1)
    with pytest.raises(SolveError, match=r"E1019.*`R.sound` does not hold"):
        model.solve()
    model.least = 2
    assert model.solve().converged


def test_what_is_not_finite_is_named() -> None:
    model = arael.loads(
        """
root R {
    param x: real
    constraint near { x }
    require positive { log(x) >= 0 }
}
""",
        interpret=True,
    )(x=-1)
    with pytest.raises(SolveError, match=r"E1001.*R.positive"):
        model.solve()

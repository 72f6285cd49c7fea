"""Independent problems in one model end as each does when it is solved alone.

The oracle is the same model with one of the problems in it: it has one component, and goes through
the loop for one component.
"""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.model import Model
from arael.result import Result
from arael.runtime.assembly import shares
from arael.runtime.assembly.components import partition_of
from arael.runtime.levenberg.loop import Minimiser
from arael.runtime.linear import narrowing
from arael.solving import problem_of

MODEL = """
struct Sample { x: real
    y: real
    constraint fit { parent.a * (1 - exp(-parent.b * x)) - y }
}
struct Decay { param a: real
    param b: real
    samples: list of Sample }

struct Valley { param x: real
    param y: real
    s: real
    constraint c { [s * 10 * (y - x*x), s * (1 - x)] }
}

struct Boxed { param x: real in 0 .. 2
    param y: real
    k: real
    constraint c { [x*x - k, y - x*k] }
}

struct Spot { p: vec2
    constraint on { norm(p - parent.c) - parent.r }
}
struct Ring { param c: vec2
    param r: real
    spots: list of Spot }

struct Shot { x: real
    y: real
    constraint fit loss cauchy(1) { 20 * (parent.a * x + parent.b - y) }
}
struct Line { param a: real
    param b: real
    shots: list of Shot }

struct Gate { param x: real
    t: real
    constraint low when x < 1 { x - 2 }
    constraint high when x >= 1 { 3 * (x - t) }
}

struct Edge { param x: real
    k: real
    constraint c { sqrt(x - 1) + k }
}

struct Sat { pos: vec3
    range: real
    constraint pseudorange { (norm(pos - parent.pos) + parent.clock - range) / 5 }
}
struct Epoch { param pos: vec3
    param clock: real
    sats: list of Sat }

struct Pair { param x: real
    param y: real
    k: real
    constraint c { 1e4 * (x + y - k) }
}

struct Root { param x: real in 0 .. 5
    constraint c { [sqrt(x), 3] }
}

root All {
    decays: list of Decay
    valleys: list of Valley
    boxes: list of Boxed
    rings: list of Ring
    lines: list of Line
    gates: list of Gate
    edges: list of Edge
    epochs: list of Epoch
    pairs: list of Pair
    roots: list of Root
    weight: real = 1
}
"""

Problem = Callable[[Any], None]
Load = Callable[[str, bool], type[Model]]


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Load]:
    """The model, compiled or interpreted, once each."""
    path = Path(tmp_path_factory.mktemp("components")) / "all.arael"
    path.write_text(MODEL)
    loaded: dict[tuple[str, bool], type[Model]] = {}

    def kind(precision: str, interpret: bool) -> type[Model]:
        key = (precision, interpret)
        if key not in loaded:
            loaded[key] = arael.load(path, precision=precision, interpret=interpret)  # type: ignore[arg-type]
        return loaded[key]

    yield kind


def problems(seed: int, rounds: int = 4) -> list[tuple[str, Problem]]:
    """Problems of all kinds in random order of kinds: name of the table, and what adds a row."""
    rng = np.random.default_rng(seed)
    found: list[tuple[str, Problem]] = []

    def rows(table: str, inner: str, values: dict[str, Any], data: dict[str, Any]) -> None:
        def add(model: Any) -> None:
            row = getattr(model, table).append(**values)
            getattr(row, inner).extend(**data)

        found.append((table, add))

    def row(table: str, **values: Any) -> None:
        found.append((table, lambda model: getattr(model, table).append(**values)))

    # At the jump of its cost it can neither go on nor stay.
    row("gates", x=0.0, t=3.0)
    for _ in range(rounds):
        x = np.linspace(0.3, 5, 8)
        a, b = rng.uniform(1, 200), rng.uniform(0.2, 3)
        y = a * (1 - np.exp(-b * x)) + rng.normal(0, 0.02 * a, 8)
        rows("decays", "samples", {"a": a * 3, "b": b * 0.05}, {"x": x, "y": y})
        row("valleys", x=-1.2 * rng.uniform(0.5, 2), y=1.0, s=10.0 ** rng.uniform(-4, 4))
        row("boxes", x=rng.uniform(0.1, 1.9), y=rng.normal(), k=rng.uniform(-2, 6))
        angle = rng.uniform(0, 6.2, 5)
        ring = rng.normal(size=2) + 3 * np.stack((np.cos(angle), np.sin(angle)), 1)
        ring += rng.normal(0, 0.1, (5, 2))
        rows("rings", "spots", {"c": [5.0, 5.0], "r": 1.0}, {"p": ring})
        shot = np.linspace(-1, 1, 9)
        far = np.where(np.arange(9) == 4, 2.0, 0.0)
        rows(
            "lines", "shots", {"a": 0.0, "b": 0.0},
            {"x": shot, "y": rng.normal() * shot + rng.normal(0, 0.05, 9) + far},
        )  # fmt: skip
        row("gates", x=rng.uniform(-3, 4), t=rng.uniform(0.5, 3))
        row("edges", x=rng.uniform(1.2, 3), k=rng.uniform(0.3, 2))
    return found


def of(kind: type[Model], chosen: list[tuple[str, Problem]]) -> Any:
    """A model with some problems in it."""
    model = kind()
    for _, add in chosen:
        add(model)
    return model


def compare(kind: type[Model], chosen: list[tuple[str, Problem]], **settings: Any) -> Result:
    """Solve all together and each alone: the same ends, by the same steps; the result of the whole.

    Equal to rounding: costs and the gradients of instances that share a block of lanes are summed
    in another order. Where that decides, a component takes another attempt at the level of noise.
    """
    result: Result = of(kind, chosen).solve(**settings)
    components = result.components
    assert components is not None and len(components) == len(chosen)
    single = kind.layout.precision == "f32"
    start = end = 0
    others = 0
    for component, k in zip(components, in_order(chosen), strict=True):
        alone = of(kind, [chosen[k]]).solve(**settings)
        start, end = end, end + len(alone.x)
        assert alone.components is None
        assert component.status == alone.status, component.name
        others += component.iterations != alone.iterations
        assert component.rows == 1
        assert component.start_cost == pytest.approx(alone.start_cost, rel=1e-12)
        assert component.end_cost == pytest.approx(
            alone.end_cost, rel=1e-4 if single else 1e-9, abs=1e-9 if single else 1e-18
        ), component.name
        near = 1e-3 if single else 1e-6
        np.testing.assert_allclose(result.x[start:end], alone.x, near, near)
    assert end == len(result.x) and others <= len(chosen) // 10
    assert result.end_cost == pytest.approx(components.end_cost.sum(), rel=1e-12)
    return result


def in_order(chosen: list[tuple[str, Problem]]) -> list[int]:
    """Numbers of problems in the order of their rows: by table, then as they were added."""
    return sorted(range(len(chosen)), key=lambda k: TABLES.index(chosen[k][0]))


COMPILED_OR_NOT = pytest.mark.parametrize("interpret", [False, True])
IN_BOTH = pytest.mark.parametrize("precision", ["f64", "f32"])


@IN_BOTH
@COMPILED_OR_NOT
@pytest.mark.parametrize("seed", range(2))
def test_all_end_as_alone(load: Load, precision: str, interpret: bool, seed: int) -> None:
    result = compare(load(precision, interpret), problems(seed), solver="sparse")
    assert result.components is not None
    # What has no minimum that a step could reach leaves the others as they are.
    stuck = [one.status for one in result.components if one.name == "gates[0]"]
    assert stuck == ["stalled"] and not result.converged
    assert result.components.converged.mean() > 0.7


@pytest.fixture
def narrowed(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Narrow the loop wherever components have ended; the scalars that remained each time."""
    seen = []
    build = narrowing.remaining_solver

    def counted(*args: Any) -> Any:
        found = build(*args)
        seen.append(found.inner.n)
        return found

    monkeypatch.setattr(narrowing, "remaining_solver", counted)
    monkeypatch.setattr(narrowing, "CONSTANT", 0)
    monkeypatch.setattr(narrowing, "MULTIPLE", 0)
    return seen


@pytest.mark.parametrize(
    ("precision", "interpret", "solver"),
    [
        ("f64", False, "sparse"),
        ("f32", False, "sparse"),
        ("f64", True, "band"),
        ("f64", False, "schur"),
        ("f64", False, "dense"),
    ],
)
def test_what_remains_ends_as_alone(
    load: Load, narrowed: list[int], precision: str, interpret: bool, solver: str
) -> None:
    # Rings may run off to an infinite radius, where rounding decides about the place.
    chosen = [one for one in problems(0, 5) if one[0] != "rings"]
    compare(load(precision, interpret), chosen, solver=solver)
    assert len(narrowed) > 5
    # Ever less; solves of one component alone do not narrow.
    assert (np.diff(narrowed) < 0).all() and narrowed[-1] <= 3


def test_what_remains_under_damping_ends_as_alone(load: Load, narrowed: list[int]) -> None:
    chosen = [one for one in problems(3) if one[0] not in ("edges", "gates")]
    tolerant = {"strategy": "damped", "damping": "nielsen", "parameter_tolerance": 1e-300}
    compare(load("f64", False), chosen, solver="sparse", **tolerant)
    assert narrowed


def test_a_failed_factorisation_of_what_remains(load: Load, narrowed: list[int]) -> None:
    """Which component it is, is found by the scalar of the whole."""
    singular: list[tuple[str, Problem]] = [
        ("pairs", lambda model, k=k: model.pairs.append(x=0.0, y=0.0, k=k)) for k in (1.0, 2.0, 3.0)
    ]
    hard = [one for one in problems(4, 2) if one[0] in ("valleys", "lines")]
    chosen = singular[:1] + hard + singular[1:]
    settings = {"solver": "sparse", "strategy": "dogleg", "lambda_floor": 0.0}
    compare(load("f64", False), chosen, **settings)
    assert narrowed


def test_a_narrowed_solve_leaves_the_problem_whole(load: Load, narrowed: list[int]) -> None:
    """The next solve of the session, from the same start, has the same bits."""
    chosen = [one for one in problems(12, 6) if one[0] in ("boxes", "valleys", "edges")]
    model = of(load("f64", False), chosen)
    model.boxes[0].y.optimize = False  # held scalars, beside bounds
    columns = [model.boxes.x, model.boxes.y, model.valleys.x, model.valleys.y, model.edges.x]
    start = [column.value.copy() for column in columns]
    first = model.solve(solver="sparse")
    steps = len(narrowed)
    for column, value in zip(columns, start, strict=True):
        column.value[:] = value
    again = model.solve(solver="sparse")
    assert steps > 2 and len(narrowed) == 2 * steps
    np.testing.assert_array_equal(first.x, again.x)
    np.testing.assert_array_equal(first.components.end_cost, again.components.end_cost)
    # At the end nothing that was passed over is out of date.
    assert again.end_cost == pytest.approx(problem_of(model).cost(), rel=1e-12)


def test_threads_change_no_bit_of_what_remains(
    load: Load, narrowed: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shares, "GRAIN", 30.0)
    kind, chosen = load("f64", False), problems(6, 12)
    one, two = (of(kind, chosen).solve(solver="sparse", num_threads=n) for n in (1, 2))
    assert narrowed
    np.testing.assert_array_equal(one.x, two.x)
    np.testing.assert_array_equal(one.components.end_cost, two.components.end_cost)


def test_a_small_problem_is_not_narrowed(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would take longer than what is passed over in vain."""
    monkeypatch.setattr(narrowing, "remaining_solver", None)
    assert of(load("f64", False), problems(2, 2)).solve(solver="sparse").components is not None


def test_an_error_while_narrowing_is_raised(load: Load, monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(*args: Any) -> None:
        raise MemoryError("none left")

    monkeypatch.setattr(narrowing, "remaining_solver", failing)
    monkeypatch.setattr(narrowing, "CONSTANT", 0)
    monkeypatch.setattr(narrowing, "MULTIPLE", 0)
    model = of(load("f64", False), problems(2, 2))
    with pytest.raises(MemoryError, match="none left"):
        model.solve(solver="sparse")


@pytest.mark.parametrize("damping", ["gain", "nielsen", "ladder"])
def test_damped_steps_end_as_alone(load: Load, damping: Any) -> None:
    chosen = [one for one in problems(3) if one[0] not in ("edges", "gates")]
    compare(load("f64", False), chosen, solver="band", strategy="damped", damping=damping)


@IN_BOTH
def test_a_failed_factorisation_is_that_of_its_component(load: Load, precision: str) -> None:
    kind = load(precision, False)
    singular: list[tuple[str, Problem]] = [
        ("pairs", lambda model, k=k: model.pairs.append(x=0.0, y=0.0, k=k)) for k in (1.0, 2.0, 3.0)
    ]
    chosen = [one for one in problems(4, 1) if one[0] not in ("edges", "gates")] + singular
    result = compare(kind, chosen, solver="sparse", strategy="dogleg", lambda_floor=0.0)
    failed = result.history[result.history["factored"] == 0]
    assert len(failed) >= 3 and (failed["accepted"] == 0).all()
    assert result.converged


def test_other_solvers_end_the_same(load: Load) -> None:
    kind, chosen = load("f64", False), problems(5)
    first = of(kind, chosen).solve(solver="sparse").components
    for solver in ("dense", "schur", "auto"):
        other = of(kind, chosen).solve(solver=solver).components
        assert (other.status == first.status).all()
        np.testing.assert_allclose(other.end_cost, first.end_cost, 1e-8, 1e-25)


@IN_BOTH
def test_threads_change_no_bit(load: Load, precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shares, "GRAIN", 30.0)
    kind, chosen = load(precision, False), problems(6, 12)
    one, two = (of(kind, chosen).solve(solver="sparse", num_threads=n) for n in (1, 2))
    np.testing.assert_array_equal(one.x, two.x)
    for name in ("iterations", "end_cost", "status"):
        np.testing.assert_array_equal(getattr(one.components, name), getattr(two.components, name))
    # Cut into shares, they end as uncut ones.
    monkeypatch.undo()
    whole = of(kind, chosen).solve(solver="sparse").components
    assert (whole.status == one.components.status).all()
    np.testing.assert_allclose(whole.end_cost, one.components.end_cost, 1e-3, 1e-6)


def test_residuals_of_run_time_end_as_alone(load: Load) -> None:
    """Parameters that only the expression machine works on."""
    kind = load("f64", False)
    rng = np.random.default_rng(8)
    starts, targets = rng.uniform(-2, 2, (6, 2)), rng.uniform(0.5, 4, 6).tolist()

    def model(chosen: Iterable[int]) -> Any:
        found = kind()
        for k in chosen:
            row = found.pairs.append(x=starts[k, 0], y=starts[k, 1], k=0.0)
            found.residuals.add(
                f"[10 * (p.y - p.x*p.x), {targets[k]!r} - p.x]", label=f"r{k}", entities={"p": row}
            )
        return found

    # The compiled constraint is there as well: each component has kernels and programs.
    result = model(range(6)).solve(solver="sparse")
    assert len(result.components) == 6
    for k, component in enumerate(result.components):
        alone = model([k]).solve(solver="sparse")
        assert (component.status, component.iterations) == (alone.status, alone.iterations)
        assert component.end_cost == pytest.approx(alone.end_cost, rel=1e-9)
        np.testing.assert_allclose(result.x[2 * k : 2 * k + 2], alone.x, rtol=1e-10)


def epochs(count: int) -> list[tuple[str, Problem]]:
    """Positions on the Earth with six to ten satellites above, started at the Earth's centre."""
    rng = np.random.default_rng(9)
    found: list[tuple[str, Problem]] = []
    for _ in range(count):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        seen = int(rng.integers(6, 11))
        ways = rng.normal(size=(seen, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        ways = np.where((ways @ up)[:, None] < 0, -ways, ways)
        place = 6.371e6 * up
        sats = place + 2.2e7 * ways
        measured = np.linalg.norm(sats - place, axis=1) + rng.normal(0, 5, seen)
        measured += rng.normal() * 3e5

        def add(model: Any, pos: Any = sats, range_: Any = measured) -> None:
            model.epochs.append(pos=[0, 0, 0], clock=0.0).sats.extend(pos=pos, range=range_)

        found.append(("epochs", add))
    return found


def test_a_thousand_epochs_converge(load: Load) -> None:
    kind, chosen = load("f64", False), epochs(1000)
    result = of(kind, chosen).solve()
    assert result.status == "converged" and result.components.converged.all()
    assert result.iterations < 15
    x = np.asarray(result.x).reshape(-1, 4)
    assert (np.abs(np.linalg.norm(x[:, :3], axis=1) - 6.371e6) < 200).all()
    for k in range(0, 1000, 50):
        alone = of(kind, [chosen[k]]).solve()
        assert result.components[k].iterations == alone.iterations
        np.testing.assert_allclose(x[k], alone.x, rtol=1e-9, atol=1e-3)


# --- what a result says -------------------------------------------------------------------------


def test_limits_are_those_of_each_component(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] != "edges"]
    kind = load("f64", True)
    free = of(kind, chosen).solve(solver="sparse").components
    result = compare(kind, chosen, solver="sparse", max_iters=12)
    found = result.components
    slow = free.iterations > 12
    assert slow.any() and not slow.all()
    assert (found.status == np.where(slow, "max_iterations", "converged")).all()
    assert found.iterations.max() == 12 == result.iterations
    assert result.status == "max_iterations" and not result.converged
    first = np.flatnonzero(slow)[0]
    expected = f"{(~slow).sum()} of {len(slow)} components converged; {found.name(int(first))}: max"
    assert found.summary().startswith(expected)
    assert found.summary() in str(result)


def test_records_are_of_all_components(load: Load) -> None:
    result = of(load("f64", True), problems(2)).solve(solver="sparse")
    history, found = result.history, result.components
    assert history["cost"][0] == result.start_cost == pytest.approx(found.start_cost.sum())
    taken = history[history["accepted"] == 1]
    np.testing.assert_array_equal(taken["cost"][1:], taken["trial_cost"][:-1])
    assert taken["trial_cost"][-1] == pytest.approx(result.end_cost, rel=1e-12)
    assert (np.diff(taken["cost"]) <= 0).all()
    rejected = history[history["accepted"] == 0]
    assert not (rejected["trial_cost"] < rejected["cost"]).any()
    assert (history["retry"][1:] == np.where(
        history["accepted"][:-1] == 1, 0, history["retry"][:-1] + 1
    )).all()  # fmt: skip
    assert len(history) == result.iterations >= found.iterations.max()
    assert result.predicted_decrease == pytest.approx(np.nansum(found.predicted_decrease))


def test_what_ends_all_leaves_those_that_had_converged(load: Load) -> None:
    seen = []

    def observer(record: Any) -> bool:
        seen.append(int(record["iteration"]))
        return len(seen) < 8

    chosen = [one for one in problems(1) if one[0] != "edges"]
    result = of(load("f64", True), chosen).solve(solver="sparse", observer=observer)
    assert result.status == "observer_terminated" and len(seen) == 8
    assert result.components.counts().keys() == {"converged", "observer_terminated"}
    late = of(load("f64", True), chosen).solve(solver="sparse", time_limit=0.0)
    assert late.components.counts() == {"time_limit": len(chosen)}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a timer's signal")
def test_ctrl_c_keeps_what_components_have_reached(load: Load, narrowed: list[int]) -> None:
    """Sent while only the hard ones are left, without an observer: the loop looks for signals."""

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    model = load("f64", False)()
    # Boxes at their solution end at once; valleys would go on for minutes with steps this short.
    for _ in range(20):
        model.boxes.append(x=1.0, y=1.0, k=1.0)
        model.valleys.append(x=-1.2, y=1.0, s=1.0)
    start = model.valleys.x.value.copy()
    previous = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, 0.2, 1.0)  # again, should one come before the loop
    try:
        result = model.solve(
            solver="sparse", strategy="damped", lambda_floor=1e7, initial_lambda=1e7,
            max_iters=10**7, rel_precision=1e-6, time_limit=60.0,
        )  # fmt: skip
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)
    components = result.components
    assert narrowed == [40] and result.status == "aborted"
    assert components.status.tolist() == 20 * ["aborted"] + 20 * ["converged"]
    assert (components.end_cost <= components.start_cost).all()
    assert result.end_cost == pytest.approx(problem_of(model).cost(), rel=1e-9)
    assert (model.valleys.x.value != start).all()
    # The session is whole.
    assert model.solve(solver="sparse").converged


def test_a_threshold_is_one_of_the_whole_cost(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] == "valleys"]
    result = of(load("f64", True), chosen).solve(cost_threshold=1e-3)
    assert result.end_cost <= 1e-3 and result.converged
    assert "cost_threshold" in result.components.status


@pytest.mark.parametrize(
    "settings",
    [{"damping": lambda record: record["damping"]}, {"ending": "small_steps"}],
    ids=["driver", "small_steps"],
)
def test_what_needs_one_lambda_solves_as_one(load: Load, settings: Any) -> None:
    chosen = [one for one in problems(1, 1) if one[0] == "boxes"] * 2
    assert of(load("f64", True), chosen).solve(max_iters=5, **settings).components is None
    config = arael.LmConfig.reference(max_iters=5)
    assert of(load("f64", True), chosen).solve(config).components is None


def test_a_constant_cost_belongs_to_no_component(load: Load) -> None:
    chosen = [one for one in problems(1) if one[0] in ("valleys", "gates")]
    model = of(load("f64", False), chosen)
    # Held: what its constraints come to stays.
    model.boxes.append(x=1.0, y=0.0, k=9.0)
    result = model.solve(freeze="boxes")
    assert len(result.components) == len(chosen)
    assert result.end_cost == pytest.approx(64.0 + 81.0 + result.components.end_cost.sum())


def test_the_table_is_data_of_json(load: Load) -> None:
    result = of(load("f64", True), problems(2, 1)).solve()
    found = json.loads(json.dumps(result.to_dict()))["passes"][0]["components"]
    assert found["count"] == 8 == len(found["name"]) == len(found["status"])
    assert found["name"][0] == "decays[0]" and sum(found["statuses"].values()) == 8
    assert found["iterations"] == result.components.iterations.tolist()
    assert found["name"] == [one.name for one in result.components]


def test_what_has_ended_is_not_evaluated(load: Load) -> None:
    """Of 400 linear problems and a hard one, the hard one alone in the end."""
    model = load("f64", False)()
    for k in range(400):
        model.boxes.append(x=1.0, y=0.0, k=1.0 + k * 1e-4)
    model.boxes.append(x=1.9, y=0.0, k=1e-9)
    problem = problem_of(model)
    partition = partition_of(problem.structure, problem.layout.groups)
    seen = []

    class Watcher:
        def started(self, minimiser: Any) -> None: ...

        def stepped(self, minimiser: Any, record: Any) -> bool:
            seen.append(sum(minimiser.lanes.evaluated()))
            return True

    minimiser = Minimiser(
        problem.evaluation,
        problem.make_solver("sparse"),
        problem.box,
        arael.LmConfig(),
        Watcher(),
        True,
        partition,
    )
    assert minimiser.run() == "converged"
    assert seen[0] == 401 and 1 <= seen[-1] <= 32
    # What is not evaluated keeps its cost.
    assert minimiser.current_cost == pytest.approx(problem.cost(), rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("solver", ["dense", "sparse", "schur"])
def test_derivatives_that_are_not_finite_end_their_component_alone(load: Load, solver: str) -> None:
    chosen: list[tuple[str, Problem]] = [one for one in problems(1, 1) if one[0] == "valleys"]
    chosen += [("roots", lambda model: model.roots.append(x=4.0)), *chosen]
    result = of(load("f64", True), chosen).solve(solver=solver)
    assert result.components.status.tolist() == ["converged", "converged", "stalled"]
    assert result.components[2].end_cost == 9.0 and result.components[2].iterations < 20
    assert of(load("f64", True), chosen[1:2]).solve(solver=solver).status == "stalled"


TABLES = (
    "decays",
    "valleys",
    "boxes",
    "rings",
    "lines",
    "gates",
    "edges",
    "epochs",
    "pairs",
    "roots",
)

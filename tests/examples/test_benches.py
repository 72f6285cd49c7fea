"""The solvers that the benchmarks compare agree, and the optimum is one. Times are not tested."""

from __future__ import annotations

import re

import pytest

import arael
from arael.demo.compare import disagreement, table
from arael.scenes import benchmark_config, columns, fill, make_scene
from tests.examples.by_scipy import refined_cost
from tests.examples.scripts import printed, script


def test_band_and_dense_agree_on_localisation() -> None:
    runs = script("bench_band").run([8, 15], repeats=1)
    assert [(one.solver, one.poses) for one in runs] == [
        ("dense", 8), ("band", 8), ("dense", 15), ("band", 15),
    ]  # fmt: skip
    for pair in (runs[:2], runs[2:]):
        assert disagreement(pair) < 1e-9
        assert pair[0].cost == pytest.approx(pair[1].cost, rel=1e-12)
        assert pair[0].parameters == 6 * pair[0].poses


def test_sparse_solvers_agree_with_dense_on_slam() -> None:
    runs = script("bench_sparse").run([12], repeats=1)
    assert {one.solver for one in runs} == {"dense", "sparse", "schur"}
    assert disagreement(runs) < 1e-7
    assert runs[0].parameters == 6 * 12 + 3 * 48


def test_cross_check_compares_every_pair() -> None:
    module = script("bench_investigate")
    runs = module.run(12, repeats=1)
    pairs = module.pairs(runs)
    assert [(a, b) for a, b, _, _ in pairs] == [
        ("dense", "sparse"), ("dense", "schur"), ("sparse", "schur"),
    ]  # fmt: skip
    for a, b, apart, costs in pairs:
        assert apart < 1e-7, (a, b)
        assert costs < 1e-12, (a, b)


def test_optimum_against_scipy() -> None:
    scene = make_scene(benchmark_config(5, landmarks=12))
    model = arael.load(str(script("bench_sparse").MODEL), precision="f64")
    instance = model()
    data = columns(scene, "slam")
    fill(instance, model.layout, data)
    instance.solve(solver="sparse", rel_precision=1e-9)  # of its own 1e-6
    assert refined_cost(data, instance) == pytest.approx(instance.cost(), rel=1e-7)


def test_table_has_a_line_for_each_run(monkeypatch, capsys) -> None:
    text = printed("bench_band", ["--poses", "5"], monkeypatch, capsys)
    assert re.search(r"^ +5 +30  band ", text, re.MULTILINE)
    assert re.search(r"^5 poses: solutions agree to \d\.\de[-+]\d+$", text, re.MULTILINE)
    runs = script("bench_band").run([5], repeats=1)
    assert len(list(table(runs, "dense"))) == 4

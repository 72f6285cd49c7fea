"""Verdicts on small calibrations: planted deficiencies are named, healthy data is not accused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from arael.analysis import verdict as verdict_of
from arael.analysis.verdict import Verdict
from arael.analysis.weakness import plain_name
from arael.diagnostics.records import AraelError
from tests.analysis import planted
from tests.analysis.planted import HEALTHY, NAMED, PLANTED
from tests.interpreted import Load, loader


@pytest.fixture(scope="module")
def load(tmp_path_factory: pytest.TempPathFactory) -> Load:
    return loader(tmp_path_factory.mktemp("verdicts"))


def judged(load: Load, name: str, seed: int = 0) -> Verdict:
    found: Verdict = PLANTED[name](load, np.random.default_rng(seed)).verdict()
    return found


def missing(verdict: Verdict) -> dict[str, set[str]]:
    """Columns that should be varied, with their components, of all unseen directions."""
    found: dict[str, set[str]] = {}
    for direction in verdict.directions:
        for one in direction.missing:
            parts = {v.part for v in one.variations}
            found.setdefault(one.variations[0].name, set()).update(parts)
    return found


def topics(verdict: Verdict) -> set[str]:
    return {one.topic for one in verdict.findings}


@pytest.mark.parametrize("name", NAMED)
def test_a_planted_deficiency_is_named(load: Load, name: str) -> None:
    wanted, words, varied = NAMED[name]
    verdict = judged(load, name)
    # Where few corners are seen, some of the parameters may not be told apart either.
    also = {"unseen"} if name == "few corners" else set()
    assert wanted <= topics(verdict) <= wanted | also, str(verdict)
    message = "\n".join(one.message for one in verdict.findings)
    for word in words:
        assert word in message
    found = missing(verdict)
    for column, parts in varied.items():
        assert parts <= found[column]
    assert not verdict.good


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMED)
def test_a_planted_deficiency_is_named_with_any_noise(load: Load, name: str) -> None:
    wanted, _, varied = NAMED[name]
    for seed in range(1, 4):
        verdict = judged(load, name, seed)
        assert wanted <= topics(verdict), (seed, str(verdict))
        assert set(varied) <= set(missing(verdict)), seed


def test_scalars_of_many_rows_are_listed_together(load: Load) -> None:
    # Rows of more than eight views are one line for each scalar; numbers of components stay.
    assert plain_name("views[3].poses[10].k[2]") == "views.poses.k[2]"
    model = planted.camera(load, np.random.default_rng(0))
    found = {one.name: one for one in model.verdict().determined}
    together = found["views.board.rotation.x"]
    assert together.rows == len(model.views) > 8
    sigma = model.covariance().marginals("views")[:, 3, 3] ** 0.5
    assert (together.sigma, together.worst) == pytest.approx((np.median(sigma), sigma.max()))
    assert found["k.y"].rows == 1


def test_what_does_not_help_is_not_named(load: Load) -> None:
    # Turns about the axis that there is, and places of the vehicle, tell nothing of the lever arm.
    found = missing(judged(load, "one rotation axis"))
    assert found == {"fixes.q": {"y", "z"}}


@pytest.mark.parametrize("seed", range(20))
def test_healthy_data_is_not_accused(load: Load, seed: int) -> None:
    # The camera takes longest: once here, and in the slow test.
    names = [name for name in HEALTHY if name != "camera"]
    name = "camera" if seed == 0 else names[seed % len(names)]
    verdict = HEALTHY[name](load, np.random.default_rng(seed)).verdict()
    assert verdict.good, str(verdict)
    assert "nothing suspicious was found" in str(verdict)


@pytest.mark.slow
@pytest.mark.parametrize("name", HEALTHY)
def test_healthy_data_is_not_accused_with_any_noise(load: Load, name: str) -> None:
    # 200 draws, and ten of each deficiency: `python -m benchmarks.verdicts`.
    for seed in range(1000, 1002 if name == "camera" else 1004):
        verdict = HEALTHY[name](load, np.random.default_rng(seed)).verdict()
        assert verdict.good, (seed, str(verdict))


def test_weights_of_rows_are_no_measurements(load: Load) -> None:
    # A smaller sigma of the same rows would lower each deviation, and determine nothing new.
    text = planted.RANGER.replace("reading:  real", "reading: real; sigma: real").replace(
        "/ 0.01 }", "/ sigma }"
    )
    model: Any = load(text)()
    rng = np.random.default_rng(0)
    model.shots.extend(
        distance=np.full(20, 2.0), reading=rng.normal(2, 0.01, 20), sigma=np.full(20, 0.01)
    )
    model.solve()
    assert missing(model.verdict()) == {"shots.distance": {""}}


def test_the_promised_deviation_is_what_more_data_gives(load: Load) -> None:
    # With as many fixes again, turned about all axes, the lever arm is known as well as promised.
    verdict = judged(load, "one rotation axis")
    direction = next(d for d in verdict.directions if d.leader == "lever.x")
    rng = np.random.default_rng(5)
    model = planted.lever(load, rng, (1, 0, 0))
    turned = planted.lever(load, rng, (0.3, 1, 0.3))
    rows = turned.fixes
    model.fixes.extend(q=rows.q, at=rows.at, seen=rows.seen)
    actual = model.covariance().marginal("lever")[0, 0] ** 0.5
    assert direction.missing[0].sigma == pytest.approx(actual, rel=1.0)
    assert direction.sigma == np.inf


def test_shares_are_the_effect_of_weights(load: Load) -> None:
    # The share of a constraint is - d log(variance) / d log(weight), by finite differences.
    text = planted.GRAPH.replace("list of Edge }", "list of Edge; w: real = 1 }").replace(
        "/ 0.01] }", "/ 0.01] * root.w }"
    )
    text = text.replace("[pos - [anchor.x, anchor.y], th - anchor.z] / 0.01 ",
                        "[pos - [anchor.x, anchor.y], th - anchor.z] * root.w / 0.01 ")  # fmt: skip
    model: Any = load(text)()
    source = planted.graph(load, np.random.default_rng(0))
    for pose in source.poses:
        held = [0, 0, 0] if pose.anchor is not None else None
        model.poses.append(pos=pose.pos.value, th=float(pose.th.value), anchor=held)
    for edge in source.edges:
        model.edges.append(
            a=model.poses[edge.a.row], b=model.poses[edge.b.row], d=edge.d, turn=edge.turn
        )
    model.solve()
    shares = {one.name: one.shares for one in model.verdict().determined}["poses.pos.x"]
    names = model.covariance().names
    mine = [k for k, name in enumerate(names) if name.endswith("pos.x")]
    before = model.covariance().sigma()[mine] ** 2
    model.w = 1.001  # of the anchor: weight 1.001^2
    after = model.covariance().sigma()[mine] ** 2
    expected = np.mean(np.log(before / after) / np.log(1.001**2))
    assert shares["Pose.hold"] == pytest.approx(expected, rel=1e-2)
    assert sum(shares.values()) == pytest.approx(1)


def test_standard_deviations_and_correlations_are_those_of_the_covariance(load: Load) -> None:
    model = planted.decay(load, np.random.default_rng(0))
    covariance = model.covariance()
    verdict = model.verdict()
    found = {one.name: one for one in verdict.determined}
    sigma = dict(zip(covariance.names, covariance.sigma(), strict=True))
    assert {n: one.sigma for n, one in found.items()} == pytest.approx(sigma)
    correlation = covariance.correlation()
    names = list(covariance.names)
    one = found["tau"]
    rho = correlation[names.index("tau"), names.index(one.partner)]
    assert one.correlation == pytest.approx(rho)
    alone = 1 / np.sqrt((model.jacobian().dense() ** 2).sum(axis=0))
    assert one.inflation == pytest.approx(sigma["tau"] / alone[names.index("tau")])


def test_the_result_of_a_solve_has_the_verdict_of_its_model(load: Load) -> None:
    model = planted.ranger(load, np.random.default_rng(0))
    result = model.solve()
    assert str(result.verdict()) == str(model.verdict())
    assert result.verdict().to_dict()["good"] is True
    with pytest.raises(AraelError, match="has no model"):
        result.passes[0].verdict()


def test_a_parameter_that_is_zero_is_remarked(load: Load) -> None:
    model: Any = load(planted.TWO_GAINS.replace("root.response * x", "x + root.response * x^2"))()
    rng = np.random.default_rng(0)
    x = np.linspace(-1, 2, 40)
    model.response.value = 0
    model.points.extend(x=x, y=1.3 * x + rng.normal(0, 0.01, 40))
    model.solve()
    verdict = model.verdict()
    assert verdict.good
    assert any("`offset`" in one and "may do without" in one for one in verdict.remarks)


def test_residuals_that_depend_on_the_place_in_the_picture_are_not_white(load: Load) -> None:
    # A lens with distortion, in a model of which it is fixed to zero.
    model = planted.camera(load, np.random.default_rng(0))
    model.k.value, model.k.fixed = [-0.2, 0.0], True
    model.solve()
    assert {"place"} <= topics(model.verdict())


def test_a_group_with_an_error_of_its_own_is_named(load: Load) -> None:
    rng = np.random.default_rng(0)
    model = planted.shutter(load, rng)
    model.features.pixel[model.features.frame.rows == 2] += [0.6, 0.0]
    model.solve()
    verdict = model.verdict()
    assert topics(verdict) & {"bias", "group"}, str(verdict)
    assert "frames[2]" in str(verdict)


@pytest.mark.parametrize("bad", [1.0, 60.0])
def test_a_group_that_a_loss_rejects_is_named(load: Load, bad: float) -> None:
    robust = planted.CAMERA.replace("constraint lens {", "constraint lens loss cauchy(2) {")

    def loaded(text: str) -> Any:
        return load(robust if text == planted.CAMERA else text)

    verdict = planted.camera(loaded, np.random.default_rng(0), bad=bad).verdict()
    found = [one.message for one in verdict.findings if one.topic == "group"]
    if bad == 1.0:
        assert verdict.good
        return
    (message,) = found
    assert "takes most of the weight" in message
    assert message.endswith("`views[3]`")


def test_a_problem_that_is_too_large_is_not_called_good(
    load: Load, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(verdict_of, "MOST_SCALARS", 1)
    verdict = planted.ranger(load, np.random.default_rng(0)).verdict()
    assert not verdict.judged and not verdict.good
    assert "not judged (2 parameters" in str(verdict)
    assert "judge a solve of part of the data" in str(verdict)


def test_a_start_that_is_no_solution_is_called_so(load: Load) -> None:
    model = planted.decay(load, np.random.default_rng(0))
    model.tau.value = 3.0
    assert "not-minimal" in topics(model.verdict())


# --- which measurements next ---------------------------------------------------------------------


def pools() -> dict[str, tuple[str, str, Any]]:
    """Candidates by problem: model, collection, columns."""
    rng = np.random.default_rng(3)
    n = 800
    q = np.array([planted.quat_exp(v) for v in rng.normal(0, 0.5, (n, 3))])
    return {
        "ranger": ("ranger", "shots", {"distance": rng.uniform(0.5, 8, n)}),
        "decay": ("decay", "samples", {"t": rng.uniform(0, 30, n)}),
        "lever": ("lever", "fixes", {"q": q * 1.0, "at": np.zeros((n, 3))}),
    }


def relative_sigma(model: Any, before: Any) -> float:
    """Root mean square of the standard deviations relative to those before."""
    return float(np.sqrt(np.mean((model.covariance().sigma() / before) ** 2)))


@pytest.mark.parametrize("criterion", ["d", "a"])
@pytest.mark.parametrize("name", ["ranger", "decay", "lever"])
def test_chosen_measurements_halve_the_deviation_with_fewer(
    load: Load, name: str, criterion: str
) -> None:
    problem, collection, columns = pools()[name]
    model = HEALTHY[problem](load, np.random.default_rng(0))
    before = model.covariance().sigma()
    found = model.next_data(150, columns, collection, criterion=criterion)
    count = next(k for k, sigma in enumerate(found.sigma) if sigma <= 0.5)

    def added(rows: Any) -> float:
        trial = model.copy()
        known = {key: np.asarray(v)[rows] for key, v in columns.items()}
        measured = {"ranger": "reading", "decay": "y", "lever": "seen"}[name]
        shape = (len(rows), 3) if name == "lever" else len(rows)
        trial[collection].extend(**known, **{measured: np.zeros(shape)})
        return relative_sigma(trial, before)

    # What was promised is the covariance with these rows, at the same parameters.
    chosen = list(found.rows)
    assert added(chosen[:count]) == pytest.approx(found.sigma[count], rel=1e-6)
    assert found.sigma[count] <= 0.5 < found.sigma[count - 1]
    # At count / 0.6 random rows the deviation is not halved yet.
    for seed in range(5):
        order = np.random.default_rng(seed).permutation(800)
        assert added(order[: int(count / 0.6)]) > 0.5


def test_the_first_choice_is_the_best_single_candidate(load: Load) -> None:
    model = planted.decay(load, np.random.default_rng(0))
    t = np.linspace(0, 60, 25)
    found = model.next_data(1, {"t": t}, "samples", of="tau", criterion="a")
    sigma = []
    for one in t:
        trial = model.copy()
        trial.samples.append(t=one, y=0.0)
        sigma.append(trial.covariance().marginal("tau")[0, 0] ** 0.5)
    assert found.rows == (int(np.argmin(sigma)),)
    assert found.sigma[1] == pytest.approx(
        min(sigma) / model.covariance().marginal("tau")[0, 0] ** 0.5
    )
    assert found.wanted == ("tau",)
    assert found.to_dict()["rows"] == list(found.rows)
    assert "A-optimal" in str(found)


def test_candidates_that_determine_a_free_direction_come_first(load: Load) -> None:
    model = planted.ranger(load, np.random.default_rng(0), (2.0, 2.0))
    found = model.next_data(2, {"distance": [2.0, 2.0, 5.0, 2.0]}, "shots")
    assert found.rows[0] == 2
    assert found.sigma[0] == np.inf and np.isfinite(found.sigma[1])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((1, {"distance": [1.0]}, "shot"), "no collection `shot`"),
        ((1, {"distance": [1.0]}, "shots", "gian"), "nothing named `gian`"),
        ((0, {"distance": [1.0]}, "shots"), "count"),
        ((1, [1.0], "shots"), "candidates"),
        ((1, {"distance": [1.0]}, "shots", None, "e"), "criterion"),
    ],
)
def test_wrong_questions_are_refused(load: Load, arguments: Any, words: str) -> None:
    model = planted.ranger(load, np.random.default_rng(0))
    with pytest.raises((AraelError, TypeError, ValueError), match=words):
        model.next_data(*arguments)


def test_candidates_with_parameters_of_their_own_are_refused(load: Load) -> None:
    model = planted.camera(load, np.random.default_rng(0), views=4)
    with pytest.raises(AraelError, match="parameters of their own"):
        model.next_data(1, {"board": [[0, 0, 1, 1, 0, 0, 0]]}, "views")


# --- the picture ----------------------------------------------------------------------------------


def test_uncertainty_of_projection_is_that_of_the_formula(load: Load) -> None:
    # pixel = f p + c with one p per row: at pixel q the derivatives by (f, c) are ((q - c) / f, 1).
    model = planted.shutter(load, np.random.default_rng(0))
    model.delay.fixed = True
    model.solve()
    (picture,) = model.projection_uncertainty((640, 480))
    covariance = model.covariance().marginal(["f", "c"])
    for q in ((320.0, 240.0), (30.0, 40.0), (600.0, 300.0)):
        x, y = (
            axis[np.argmin(np.abs(axis - v))]
            for axis, v in zip((picture.x, picture.y), q, strict=True)
        )
        p = (np.array([x, y]) - model.c.value) / float(model.f.value)
        slopes = np.column_stack([p, np.eye(2)])
        expected = np.sqrt(np.linalg.eigvalsh(slopes @ covariance @ slopes.T)[-1])
        assert picture.at(x, y) == pytest.approx(expected, rel=1e-6)


def test_uncertainty_of_projection_grows_where_nothing_was_seen(load: Load) -> None:
    model = planted.camera(load, np.random.default_rng(0), seen=0.5)
    (picture,) = model.projection_uncertainty((640, 480))
    assert picture.camera == "m" or picture.camera
    assert picture.at(320, 240) < 0.1 < 1 < picture.at(20, 20)
    assert picture.to_dict()["sigma"][0][0] == pytest.approx(picture.sigma[0, 0])


def test_a_model_without_pixels_has_no_picture(load: Load) -> None:
    with pytest.raises(AraelError, match="E0791"):
        planted.ranger(load, np.random.default_rng(0)).projection_uncertainty()

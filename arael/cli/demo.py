"""`arael demo`: synthetic problems, solved and compared with the truth."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from arael.cli import summary
from arael.cli.exits import Exit
from arael.cli.options import (
    F,
    json_option,
    plot_option,
    plot_target,
    precision_option,
    solver_option,
    threads_option,
)
from arael.cli.solve import require_picture
from arael.demo import linear as linear_demo
from arael.demo import localization as localization_demo
from arael.demo import slam as slam_demo
from arael.demo.scene_run import SolveOptions
from arael.scenes import demo_config


@click.group("demo", short_help="Run a demonstration on synthetic data.")
def command() -> None:
    """Generate a problem with known truth, solve it, and report the error of the solution."""


def scene_options(function: F) -> F:
    """Add the options that choose a scene."""
    for option in reversed(
        (
            click.option(
                "--poses",
                type=click.IntRange(2, 100_000),
                default=60,
                show_default=True,
                help="Number of poses.",
            ),
            click.option(
                "--landmarks",
                type=click.IntRange(1, 1_000_000),
                help="Number of landmarks.  [default: four per pose]",
            ),
            click.option(
                "--trajectory",
                type=click.Choice(["s-curve", "loop", "eight"]),
                default="s-curve",
                show_default=True,
                help="Shape of the path.",
            ),
            seed_option,
            *solve_options,
        )
    ):
        function = option(function)
    return function


seed_option = click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=42,
    show_default=True,
    help="Seed of the random numbers.",
)
quiet_option = click.option("-q", "--quiet", is_flag=True, help="No trace of the solver's steps.")
solve_options: tuple[Callable[[Any], Any], ...] = (
    solver_option,
    precision_option,
    threads_option,
    quiet_option,
    plot_option,
    json_option,
)


@command.command("slam", short_help="Poses and landmarks, half of the associations wrong.")
@scene_options
def slam(**options: Any) -> int:
    """Visual-inertial SLAM in three passes, with half of the data associations wrong."""
    return _present(
        slam_demo,
        lambda: slam_demo.run_slam(demo_config(**_scene(options)), _how(options)),
        options,
    )


@command.command("localization", short_help="The same with a known map.")
@scene_options
def localization(**options: Any) -> int:
    """Localization in a known map, with half of the data associations wrong."""
    return _present(
        localization_demo,
        lambda: localization_demo.run_localization(demo_config(**_scene(options)), _how(options)),
        options,
    )


@command.command("linear", short_help="A line, by least squares and robustly.")
@click.option("--points", type=click.IntRange(2, 1_000_000), default=100, show_default=True)
@seed_option
@solver_option
@precision_option
@threads_option
@quiet_option
@plot_option
@json_option
def linear(**options: Any) -> int:
    """Line fit with outliers: least squares and a robust fit."""

    def run() -> Any:
        return linear_demo.run_linear(
            options["points"], seed=options["seed"], options=_how(options)
        )

    return _present(linear_demo, run, options)


def _scene(options: dict[str, Any]) -> dict[str, Any]:
    return {name: options[name] for name in ("poses", "landmarks", "trajectory", "seed")}


def _how(options: dict[str, Any]) -> Any:
    return SolveOptions(
        solver=options["solver"],
        precision=options["precision"],
        threads=options["threads"],
        verbose=not (options["quiet"] or options["as_json"]),
    )


def _present(demo: Any, run: Callable[[], Any], options: dict[str, Any]) -> int:
    """Run a demo, print its report, draw its figures."""
    picture = plot_target(options["plot"], demo.__name__.rpartition(".")[2])
    require_picture(picture)
    done = run()
    written = demo.plot(done, Path(picture)) if picture is not None else []
    if options["as_json"]:
        found = {**summary.as_dict(done.result), **demo.summary(done), "written": written}
        click.echo(json.dumps(summary.plain(found)))
    else:
        for line in demo.report(done):
            click.echo(line)
        for file in written:
            click.echo(f"wrote {file}")
    return Exit.OK if summary.has_converged(done.result) else Exit.NOT_CONVERGED

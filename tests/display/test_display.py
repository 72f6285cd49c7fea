"""What notebooks and rich terminals show of models and results."""

from __future__ import annotations

import re
import sys
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from rich.console import Console

import arael
from arael.display import progress
from arael.display.sheet import Sheet
from tests.optional import require

TEXT = """
struct Pose {
    param pos: vec2 [m]
    skip name: string = "<b>&"
    marks: list of Mark
    constraint near { pos - [1, 2] }
}
struct Mark { at: real }
root Path {
    param scale: real = 2
    poses: list of Pose
    speed: real
    constraint one { scale * scale - 3 }
    solve { pass a { freeze poses } pass b { } }
}
"""


class Cells(HTMLParser):
    """Rows of the tables of a page; fails on tags that are not closed."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.open: list[str] = []
        self.text = ""
        self.feed(page)
        assert not self.open

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)
        self.text = ""
        if tag == "tr":
            self.rows.append([])

    def handle_data(self, data: str) -> None:
        self.text += data

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag
        if tag in ("td", "th"):
            self.rows[-1].append(self.text)


def rows(shown: Any) -> list[list[str]]:
    return Cells(shown._repr_html_()).rows


def printed(shown: Any) -> str:
    console = Console(width=100, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(shown)
    return console.export_text()


@pytest.fixture
def path() -> arael.Model:
    found = arael.loads(TEXT, interpret=True)()
    for k in range(15):
        found.poses.append(pos=[k, 0])
    return found


def test_a_model_shows_its_fields(path: arael.Model) -> None:
    assert rows(path) == [
        ["field", "type", "value"],
        ["scale", "param real", "2"],
        ["speed", "real", "not set"],
        ["poses", "list of Pose", "15 rows"],
    ]
    path.speed = 3.0
    path.scale.fixed = True
    assert rows(path)[1][2] == "2 (fixed)" and rows(path)[2][2] == "3"
    assert "poses" in printed(path) and "15 rows" in printed(path)


def test_a_collection_shows_its_first_and_last_rows(path: arael.Model) -> None:
    found = rows(path.poses)
    assert found[0] == ["row", "pos", "name", "marks"]
    assert [row[0] for row in found[1:]] == [*map(str, range(7)), "...", "12", "13", "14"]
    assert found[1][1:] == ["[0. 0.]", "'<b>&'", "[0]"]
    assert "<b>&" not in path.poses._repr_html_().replace("<b>list", "")
    assert [row[0] for row in rows(path.poses[3:5])[1:]] == ["3", "4"]
    assert "list of Pose poses: 15 rows" in printed(path.poses)


def test_a_result_shows_its_passes(path: arael.Model) -> None:
    path.speed = 1.0
    result = path.solve()
    found = rows(result)
    assert [row[0] for row in found] == ["pass", "a", "b"]
    assert found[2][1] == "converged"
    assert "solver" in result._repr_html_() and "converged" in printed(result)
    assert len(rows(result.passes[0])) == 0  # a single pass is one line


def test_a_cost_table_is_a_table(path: arael.Model) -> None:
    path.speed = 1.0
    table = path.cost_table()
    found = rows(table)
    assert [row[0] for row in found] == ["constraint", "Path.one", "Pose.near", "total"]
    assert re.sub(r"\s+", " ", printed(table)).startswith("cost by constraint constraint cost")
    assert str(table).splitlines()[0].split() == found[0]


def test_all_text_is_escaped() -> None:
    sheet = Sheet("<t>", ("<h>",), [("<c>",)], ("<n>",))
    assert not re.search(r"<[thcn]>", sheet.html())
    assert "[bold]x" in printed(Sheet("[bold]x"))


class Clock:
    """Time that passes by a step with each reading."""

    def __init__(self, step: float) -> None:
        self.now, self.step = 0.0, step

    def monotonic(self) -> float:
        self.now += self.step
        return self.now


def test_progress_is_shown_after_a_second_and_removed(
    path: arael.Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    path.speed = 1.0
    lines: list[str] = []
    monkeypatch.setattr(progress, "time", Clock(0.45))
    monkeypatch.setattr(progress, "progress_for", lambda wanted: progress.Progress(lines.append))
    seen = []
    result = path.solve(observer=lambda record: seen.append(record))
    assert len(seen) == result.iterations
    assert lines[-1] == "" and lines[0].startswith("attempt 3, cost ")
    lines.clear()
    monkeypatch.setattr(progress, "time", Clock(1e-3))
    path.solve()
    assert lines == []


def test_progress_is_removed_after_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    lines: list[str] = []
    monkeypatch.setattr(progress, "time", Clock(5.0))
    monkeypatch.setattr(progress, "progress_for", lambda wanted: progress.Progress(lines.append))
    model = arael.loads(
        "root R { param a: real = 1; constraint c { a * a - 2 } }", interpret=True
    )()

    def observer(record: Any) -> None:
        raise ValueError

    with pytest.raises(ValueError):
        model.solve(observer=observer)
    assert lines and lines[-1] == ""


def test_nothing_is_shown_in_a_script(path: arael.Model, capsys: pytest.CaptureFixture) -> None:
    assert progress.progress_for(None) is None and progress.progress_for(True) is None
    path.speed = 1.0
    path.solve(progress=True)
    assert capsys.readouterr() == ("", "")


def test_a_notebook_shows_progress_in_its_cell(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[Any] = []

    class Handle:
        def update(self, what: Any) -> None:
            shown.append(what.data)

    def display(what: Any, display_id: bool) -> Handle:
        shown.append(what.data)
        return Handle()

    shell = type("Shell", (), {"kernel": object()})()
    package = type("IPython", (), {"get_ipython": staticmethod(lambda: shell)})
    html = type("HTML", (), {"__init__": lambda self, data: setattr(self, "data", data)})
    inside = type("display", (), {"HTML": html, "display": staticmethod(display)})
    monkeypatch.setitem(sys.modules, "IPython", package)  # type: ignore[arg-type]
    monkeypatch.setitem(sys.modules, "IPython.display", inside)  # type: ignore[arg-type]
    watch = progress.progress_for(None)
    assert watch is not None
    watch._next = 0.0
    watch(np.array((1.5,), dtype=[("cost", float)])[()])
    watch.clear()
    assert shown[0].startswith("<pre>attempt 1, cost 1.5") and shown[1] == ""


def test_a_cell_is_a_model() -> None:
    from arael.notebook import load_ipython_extension

    class Shell:
        user_ns: dict[str, Any] = {}  # noqa: RUF012

        def register_magic_function(self, function: Any, kind: str, name: str) -> None:
            assert (kind, name) == ("cell", "arael")
            self.magic = function

    shell = Shell()
    load_ipython_extension(shell)
    text = "root Mean { param m: real = 0; x: real; constraint c { m - x } }"
    shell.magic("--precision f32", text)
    mean = shell.user_ns["Mean"](x=2)
    assert mean.solve().converged and mean._compiled.layout.precision == "f32"
    shell.magic("Other --interpret", text)
    assert shell.user_ns["Other"].layout.root == "Mean"


def test_mistakes_in_a_cell_are_printed(capsys: pytest.CaptureFixture) -> None:
    require("IPython")
    from IPython.core.error import UsageError

    from arael.notebook import load_ipython_extension

    shell = type("Shell", (), {"user_ns": {}})()
    shell.register_magic_function = lambda f, kind, name: setattr(shell, "magic", f)
    load_ipython_extension(shell)
    shell.magic("", "roof R { }")
    assert "error[E0" in capsys.readouterr().out and shell.user_ns == {}
    with pytest.raises(UsageError, match="unknown option '--fast'"):
        shell.magic("--fast", "root R { }")


def test_models_and_results_draw_themselves(path: arael.Model) -> None:
    require("matplotlib")
    path.speed = 1.0
    assert path.plot().get_suptitle() == "Path\n15 poses"
    assert "Pose" in path.plot("residuals").axes[0].get_title(loc="left")
    fit = arael.loads("root R { param a: real = 1; constraint c { a - 2 } }", interpret=True)()
    assert fit.plot().axes


LINE = """
struct Point { x: real; y: real [m] }
root Line {
    param a: real [m] = 0
    param b: real [m] in 0 .. 0.5 = 0.2
    points: list of Point
    fit points as p { a * p.x + b - p.y }
}
"""


def test_reports_covariances_and_fits_are_tables() -> None:
    line = arael.loads(LINE, interpret=True)()
    line.points.extend(x=[0.0, 1.0, 2.0, 3.0], y=[0.1, 2.2, 3.9, 6.1])
    line.solve()
    cells = Cells(line.report()._repr_html_())
    assert cells.rows[0] == ["parameter", "value", "standard error", "unit", ""]
    assert [row[0] for row in cells.rows[1:]] == ["a", "b"]
    assert cells.rows[1][1:4] == [f"{line.a.value:.2f}", f"{line.covariance().sigma()[0]:.2f}", "m"]
    page = line.covariance()._repr_html_()
    cells = Cells(page)
    assert cells.rows[0] == ["parameter", "standard error", "unit", "a", "b"]
    assert [row[3] for row in cells.rows[1:]] == ["1.000", cells.rows[1][4]]
    assert 'style="text-align:left">m<' in page
    marginal = line.covariance().table(["a", "b"])
    cells = Cells(marginal._repr_html_())
    assert cells.rows[0] == ["parameter", "standard error", "unit", "a", "b"]
    assert cells.rows[1][1] == f"{line.covariance().sigma()[0]:.2f}"
    assert cells.rows[1][4] == f"{line.covariance().correlation()[0, 1]:.3f}"
    cells = Cells(line.jacobian()._repr_html_())
    assert cells.rows[0] == ["constraint", "residual", "a", "b"]
    assert [row[2:] for row in cells.rows[1:]] == [[f"{x}", "1"] for x in range(4)]
    (check,) = Cells(line.check_gradients()._repr_html_()).rows[1:]
    assert check[:2] == ["Line.points", "4"] and check[4] == "yes"
    cells = Cells(line._repr_html_())
    assert ["a", "param real [m]"] in [row[:2] for row in cells.rows]
    fit = arael.fit("y = a * x + b", {"x": [0.0, 1.0, 2.0, 3.0], "y": [0.1, 2.2, 3.9, 6.1]})
    page = fit._repr_html_()
    assert "Fit of a*x+b: 4 points" in page.replace(" * ", "*").replace(" + ", "+")
    assert [row[0] for row in Cells(page).rows[1:]] == ["a", "b"]


def test_a_line_on_a_terminal_is_replaced_and_removed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TERM", "xterm")
    show = progress.OnTerminal()
    show("attempt [1]")
    show("attempt [2]")
    show("")
    show("")
    written = capsys.readouterr().err
    assert "attempt [1]" in written and "attempt [2]" in written
    assert written.rstrip().endswith("\x1b[2K")  # the line is erased

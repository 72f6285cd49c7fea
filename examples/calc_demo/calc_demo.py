"""The calculator of `arael calc`, with its input lines shown.

    python calc_demo.py [FILE] [--plot calc_demo.png]

Without FILE it runs `session.calc` in this folder; `-` reads lines from the terminal.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from pathlib import Path

from arael import AraelError
from arael.calculator.calculator import Calculator
from arael.diagnostics.render import render


def transcript(lines: Iterable[str]) -> list[str]:
    """Evaluate lines; return them in the form of a terminal session."""
    calculator = Calculator()
    shown = []
    for number, line in enumerate(lines, 1):
        shown.append(f"> {line}")
        try:
            shown += [answer.text for answer in calculator.run(line, f"line {number}")]
        except AraelError as error:
            shown += render(error.diagnostics).rstrip().splitlines()
    return [text for text in shown if text]


def draw(lines: list[str], path: Path) -> None:
    """Draw a transcript."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure = plt.figure(figsize=(6.4, 0.17 * len(lines) + 0.2), facecolor="#1e1e24")
    for i, line in enumerate(lines):
        color = "#7fd1b9" if line.startswith(">") else "#f2f2f2"
        figure.text(
            0.03,
            1 - (i + 1) / (len(lines) + 1),
            line.replace("$", r"\$"),
            color=color,
            family="monospace",
            fontsize=8,
            parse_math=False,
        )
    figure.savefig(path, dpi=90)
    plt.close(figure)
    print("wrote", path)


def main() -> None:
    """Show a session, or run an interactive one."""
    parser = argparse.ArgumentParser(description="A calculator similar to bc.")
    parser.add_argument("file", nargs="?", default=str(Path(__file__).with_name("session.calc")))
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    if args.file == "-":
        from arael.cli.main import run

        run(["calc", "--interactive"])
        return
    lines = transcript(Path(args.file).read_text(encoding="utf-8").splitlines())
    print("\n".join(lines))
    if args.plot:
        draw(lines, args.plot)


if __name__ == "__main__":
    main()

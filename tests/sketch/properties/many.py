"""Any number of random commands, each undone and redone; what breaks, with a script that shows it.

Run by ``python -m tests.sketch.properties.many --count 1000000 --seed 0``. A sketch lives for some
commands of all kinds, those that modify among them. Every one is done, undone and redone, and every
state is found again bit by bit; a refused one changes nothing. Whatever is found otherwise is
printed with the lines that lead there, and the run goes on with another sketch.
"""

from __future__ import annotations

import argparse
import faulthandler
import sys
import time
import traceback
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.solve.extents import extents_of
from tests.sketch.properties.generator import Everything, perform, snapshot

#: Commands of one sketch.
LIFE = 150
#: Of the largest residual, relative to the size of the sketch.
OPEN = 1e-7


class Fault(Exception):
    """A property that does not hold."""


@dataclass
class Tally:
    """What a run did.

    Attributes
    ----------
    done, refused : commands; the ones done were undone and redone, too
    codes : of the refusals
    slow : the longest time of a command in seconds, and the command
    faults : what failed, and the lines that lead there
    """

    done: int = 0
    refused: int = 0
    codes: Counter[str] = field(default_factory=Counter)
    slow: tuple[float, str] = (0.0, "")
    faults: list[tuple[str, list[str]]] = field(default_factory=list)


def step(session: Session, line: str, tally: Tally) -> bool:
    """Do, undo and redo a line; False if it was refused.

    Raises
    ------
    Fault
        A state is not found again.
    """
    document = session.document
    before, place = snapshot(document), document.history.position
    start = time.perf_counter()
    try:
        perform(session, line)
    except AraelError as error:
        if snapshot(document) != before or document.history.position != place:
            raise Fault("a refused command changed the sketch") from None
        tally.refused += 1
        tally.codes[error.diagnostics[0].code] += 1
        return False
    finally:
        tally.slow = max(tally.slow, (time.perf_counter() - start, line))
    tally.done += 1
    after = snapshot(document)
    if not np.isfinite(document.values).all():
        raise Fault("numbers that are not finite")
    if document.history.position == place:
        if after != before:
            raise Fault("changed without a step")
        return True
    if document.history.position != place + 1:
        raise Fault(f"{document.history.position - place} steps")
    session.run("undo")
    if snapshot(document) != before:
        raise Fault("not as before after undo")
    session.run("redo")
    if snapshot(document) != after:
        raise Fault("not as before after undo and redo")
    return True


def examine(session: Session) -> None:
    """What holds for a sketch as a whole.

    Raises
    ------
    Fault
        An equation is open; the layout is another one than that of a new editor.
    """
    editor = session.editor
    for entity in editor.document.entities.values():
        for what, found in extents_of(
            entity.kind, editor.document.numbers_of(entity.name).tolist()
        ):
            if not found > 0.0:
                raise Fault(f"the {what} of {entity.name} is {found}")
    editor.layout.check()
    system = editor.layout.linearisation()
    residuals = np.abs(system.residuals)
    if residuals.max(initial=0.0) > OPEN * editor.layout.size:
        worst = system.owners[int(residuals.argmax())]
        raise Fault(f"an equation of {worst} is open by {residuals.max():.1e}")


def life(seed: int, steps: int, tally: Tally, verbose: bool = False) -> list[str]:
    """One sketch; its lines in order, refused ones, too. A fault is put into the tally."""
    session = Session()
    generator = Everything(session, seed)
    lines: list[str] = []
    line = ""
    try:
        for k in range(steps):
            line = generator.line()
            if verbose:
                print(f"seed {seed} step {k}: {line}", flush=True)
            step(session, line, tally)
            lines.append(line)
            if k % 25 == 24:
                examine(session)
    except (Exception, RecursionError) as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        what = f"{type(error).__name__}: {error} ({where.name}, line {where.lineno})"
        tally.faults.append((f"seed {seed}: {what}", [*lines, line]))
        return lines
    # The whole life, back to nothing.
    session.run(f"undo {session.document.history.position}")
    if session.document.entities or len(session.document.values):
        tally.faults.append((f"seed {seed}: something is left after the last undo", lines))
    return lines


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and report; 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10_000, help="commands")
    parser.add_argument("--seed", type=int, default=0, help="of the first sketch")
    parser.add_argument("--stop", type=float, default=float("inf"), help="after so many seconds")
    parser.add_argument("--verbose", action="store_true", help="print every seed and every line")
    chosen = parser.parse_args(arguments)
    faulthandler.enable()
    tally, began, seed, told = Tally(), time.monotonic(), chosen.seed, 0
    while tally.done + tally.refused < chosen.count and time.monotonic() - began < chosen.stop:
        life(seed, LIFE, tally, chosen.verbose)
        seed += 1
        for what, lines in tally.faults[told:]:
            print(what, *(f"    {line}" for line in lines), sep="\n", flush=True)
        told = len(tally.faults)
    print(
        f"{tally.done} commands done, undone and redone, {tally.refused} refused, in "
        f"{seed - chosen.seed} sketches and {time.monotonic() - began:.0f} s; "
        f"{len(tally.faults)} faults; longest {tally.slow[0]:.2f} s: {tally.slow[1]}"
    )
    print("refusals:", ", ".join(f"{code} {count}" for code, count in tally.codes.most_common()))
    return 1 if tally.faults else 0


if __name__ == "__main__":
    sys.exit(main())

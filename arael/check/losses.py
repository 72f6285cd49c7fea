"""Rule: a loss is a function of the squared residual that starts at zero and rises from there.

Allowed: ``loss cauchy(c)`` and the other names of `LOSSES` with a positive scale from data or
constants; ``loss |s| expr`` over ``s``, data and constants.

Not allowed: another name, no scale or two, a scale that is zero, negative or solved for; a
user-defined loss that is not zero, decreases, or has infinite slope at zero.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from arael.check.arithmetic import NotConstant, Values, evaluate
from arael.check.binding import Broken
from arael.check.builtins import FUNCTIONS, is_number
from arael.check.scope import Candidate, Scope
from arael.check.suggest import did_you_mean
from arael.check.typed import REAL, Loss, Read, SquaredNorm, Typed
from arael.check.types import size_of
from arael.check.typist import Typist
from arael.check.walk import postorder
from arael.diagnostics.records import Label, Span
from arael.syntax import tree

LOSSES = ("cauchy", "dcs", "fair", "geman_mcclure", "huber", "soft_l1", "tukey", "welsch")

# Values for the data that a user-defined loss reads, when its behaviour at zero is checked.
_SCALES = (0.7, 1.9, 3.1)
_SMALL, _SMALLER = 1e-8, 1e-12


@dataclass
class LossScope:
    """Inside ``|s| expr``: the argument, then the scope of the constraint."""

    around: Scope
    argument: SquaredNorm
    name: tree.Ident

    def candidates(self, name: str) -> list[Candidate]:
        """All candidates for `name`; the argument shadows outer names."""
        if name == self.name.id:
            return [Candidate("the argument of the loss", self.name.span, lambda _: self.argument)]
        return self.around.candidates(name)

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        return [self.name.id, *self.around.names()]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        return self.around.advice(name)


def loss_of(t: Typist, node: tree.Expr) -> Loss | None:
    """The loss of a constraint; None after an error."""
    loss = _own(t, node) if isinstance(node, tree.Lambda) else _named(t, node)
    if loss is None:
        return None
    read = [n for n in postorder([loss.value]) if isinstance(n, Read) and n.version == "trial"]
    if not read:
        return loss
    t.fail(
        "E0643",
        node.span,
        "loss reads a parameter",
        label="minimising would reduce it",
        labels=[Label(read[0].span, "solved for")],
        help=[
            "take the scale from data: `loss cauchy(root.c)`, which a pass may set; or "
            "read `x.value`, which is constant during a solve"
        ],
    )
    return None


def _named(t: Typist, node: tree.Expr) -> Loss | None:
    if not isinstance(node, tree.Call):
        return None  # reported by the parser
    name = node.func.id if isinstance(node.func, tree.Name) else ""
    if name not in LOSSES:
        written = node.func.span.text
        help_ = did_you_mean(name, LOSSES) if name else []
        if name in FUNCTIONS or name in t.declarations.functions:
            help_ = [f"apply it to the squared residual: `loss |s| {name}(...)`"]
            if name == "starship":
                help_ = ["`starship` is applied to the residual itself: `starship(r, gamma)`"]
        t.fail(
            "E0640",
            node.func.span,
            f"unknown loss `{written}`",
            label="not found",
            notes=[f"there are {', '.join(LOSSES)}, and `|s| ...` for a user-defined one"],
            help=help_,
        )
        return None
    if len(node.args) != 1:
        count = len(node.args) or "none"
        t.fail(
            "E0641",
            node.span,
            f"loss `{name}` takes one scale, found {count}",
            label="in this loss",
            help=[f"write `{name}(2.0)`: it limits the influence of residuals above about 2 sigma"],
        )
        return None
    scale = t.number(node.args[0])
    if isinstance(scale, Broken):
        return None
    if not is_number(scale.type):
        t.fail(
            "E0641",
            node.args[0].span,
            f"the scale of a loss is a number, found {scale.type}",
            label=f"this is {scale.type}",
            labels=t.origin(scale),
        )
        return None
    try:
        (value,) = evaluate(scale)
    except NotConstant:
        value = 1.0
    if value <= 0:
        t.fail(
            "E0642",
            node.args[0].span,
            f"the scale of a loss is positive, found {value:g}",
            label="not positive",
            help=["it is the size of a residual, in sigmas, above which its influence is limited"],
        )
        return None
    return Loss(name, scale, None, node.span, _text(node.span))


def _own(t: Typist, node: tree.Lambda) -> Loss | None:
    if len(node.params) != 1:
        t.fail(
            "E0641",
            node.span,
            f"a loss takes one argument, found {len(node.params)}",
            label="the squared residual",
            help=["write `loss |s| ...` with one name"],
        )
        return None
    argument = SquaredNorm(type=REAL, span=node.params[0].span)
    before = t.scope
    t.scope = LossScope(before, argument, node.params[0])
    value = t.number(node.body)
    t.scope = before
    if isinstance(value, Broken):
        return None
    name = node.params[0].id
    if not is_number(value.type):
        t.fail(
            "E0641",
            node.body.span,
            f"a loss is a number, found {value.type}",
            label=f"this is {value.type}",
        )
        return None
    if not any(n is argument for n in postorder([value])):
        t.fail(
            "E0644",
            node.body.span,
            f"the loss does not depend on `{name}`",
            label="independent of the residual",
            labels=[Label(node.params[0].span, "the squared residual")],
        )
        return None
    loss = Loss("", value, argument, node.span, _text(node.span))
    return loss if _starts_well(t, loss, name) else None


def _starts_well(t: Typist, loss: Loss, name: str) -> bool:
    """Whether a user-defined loss is zero at zero and increases there with a finite slope."""
    starts = [_start(loss, scale) for scale in _SCALES]
    if all(abs(start) > 1e-5 for start in starts):
        shown = f", found {starts[0]:g}" if len({*starts}) == 1 else ""
        what = f"the loss is not 0 at {name} = 0{shown}"
        help_ = "subtract its value at 0: a residual of zero has no cost"
    elif all((_at(loss, _SMALL, scale) or 0.0) < 0 for scale in _SCALES):
        what = f"the loss decreases at {name} = 0"
        help_ = "change its sign: a loss increases with the squared residual"
    elif all(_steep(loss, scale) for scale in _SCALES):
        what = f"the loss has infinite slope at {name} = 0"
        help_ = (
            f"smooth it: `2 * (sqrt({name} + 1) - 1)` in place of `sqrt({name})`, or use "
            "`huber`, which is linear for large residuals and quadratic for small ones"
        )
    else:
        return True
    label = "as a function of the squared residual"
    t.fail("E0644", loss.value.span, what, label=label, help=[help_])
    return False


def _steep(loss: Loss, scale: float) -> bool:
    small, smaller = _at(loss, _SMALL, scale), _at(loss, _SMALLER, scale)
    if small is None or smaller is None or small <= 0:
        return False
    return smaller / _SMALLER > 10 * small / _SMALL


def _start(loss: Loss, scale: float) -> float:
    """The loss at zero, or close to it if that is 0 / 0."""
    start = _at(loss, 0.0, scale)
    return (_at(loss, _SMALLER, scale) or 0.0) if start is None else start


def _at(loss: Loss, s: float, scale: float) -> float | None:
    """The loss at `s` with all data equal to `scale`; None if that is not finite."""

    def given(node: Typed) -> Values | None:
        if node is loss.argument:
            return (s,)
        return (scale,) * size_of(node.type) if isinstance(node, Read) else None

    try:
        (value,) = evaluate(loss.value, given)
    except NotConstant:
        return None
    return value if math.isfinite(value) else None


def _text(span: Span) -> str:
    return " ".join(span.text.split())

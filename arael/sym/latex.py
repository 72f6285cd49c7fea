"""The notation of LaTeX's mathematics."""

from __future__ import annotations

import math
import re

from arael.runtime.machine.library import FUNCTIONS
from arael.symbolic.printers.infix import ATOM, Form, Notation
from arael.symbolic.scalars import SCALARS

_GREEK = frozenset(
    {
        *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa"),
        *("lambda", "mu", "nu", "xi", "pi", "rho", "sigma", "tau", "upsilon", "phi", "chi", "psi"),
        *("omega", "Gamma", "Delta", "Theta", "Lambda", "Xi", "Pi", "Sigma", "Upsilon", "Phi"),
        *("Psi", "Omega"),
    }
)
_NAMED = {
    **{f.name: f.latex for f in FUNCTIONS if f.latex},
    "min": "\\min",
    "max": "\\max",
}


_TIMES = "\x00"  # stands for a product until `finished` sees what follows


def finished(text: str) -> str:
    """Finish what the notation has written: products, and parentheses that grow."""
    text = re.sub(f"{_TIMES}(?=[0-9])", r" \\cdot ", text).replace(_TIMES, " ")
    text = re.sub(r"(?<!\\left)\(", r"\\left(", text)
    return re.sub(r"(?<!\\right)\)", r"\\right)", text)


def latex_name(name: str) -> str:
    """Write the name of a variable: Greek letters as such, what follows ``_`` or ``.`` below."""
    head, *below = name.replace(".", "_").strip("_").split("_")
    index = [_word(part) for part in below if part]
    return _word(head) + (f"_{{{', '.join(index)}}}" if index else "")


def _word(part: str) -> str:
    letters = part.rstrip("0123456789")
    digits = part[len(letters) :]
    if not letters or not digits or (letters not in _GREEK and len(letters) > 1):
        digits, letters = "", part
    word = f"\\{letters}" if letters in _GREEK else letters
    if letters not in _GREEK and len(letters) > 1 and not letters.isdigit():
        word = f"\\mathrm{{{letters}}}"
    return f"{word}_{{{digits}}}" if digits else word or "x"


def _literal(value: float) -> str:
    if not math.isfinite(value):
        return "\\mathrm{NaN}" if math.isnan(value) else "\\infty" if value > 0 else "-\\infty"
    if value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    digits, _, exponent = repr(value).partition("e")
    if not exponent:
        return digits
    power = f"10^{{{int(exponent)}}}"
    return power if digits == "1" else f"{digits} \\cdot {power}"


def _call(name: str, arity: int) -> Form:
    arguments = ", ".join(f"{{{i}}}" for i in range(arity))
    spelt = _NAMED.get(name) or "\\operatorname{" + name.replace("_", "\\_") + "}"
    spelt = spelt.replace("{", "{{").replace("}", "}}")
    return Form(f"{spelt}\\left({arguments}\\right)")


_OPERATORS = {
    "add": Form("{0} + {1}", 6, (6, 7)),
    "sub": Form("{0} - {1}", 6, (6, 7)),
    "mul": Form("{0}" + _TIMES + "{1}", 8, (7, 9)),
    "div": Form("\\frac{{{0}}}{{{1}}}", 9, (0, 0)),
    "neg": Form("-{0}", 7, (8,)),
    "pow": Form("{0}^{{{1}}}", 10, (ATOM, 0)),
    "sqrt": Form("\\sqrt{{{0}}}"),
    "cbrt": Form("\\sqrt[3]{{{0}}}"),
    "abs": Form("\\left|{0}\\right|"),
    "floor": Form("\\left\\lfloor {0} \\right\\rfloor"),
    "ceil": Form("\\left\\lceil {0} \\right\\rceil"),
    "lt": Form("{0} < {1}", 5, (6, 6)),
    "le": Form("{0} \\le {1}", 5, (6, 6)),
    "eq": Form("{0} = {1}", 5, (6, 6)),
    "ne": Form("{0} \\ne {1}", 5, (6, 6)),
    "and": Form("{0} \\wedge {1}", 3, (3, 4)),
    "or": Form("{0} \\vee {1}", 2, (2, 3)),
    "not": Form("\\neg {0}", 4, (9,)),
    "select": Form(
        "\\begin{{cases}} {1} & \\text{{if }} {0} \\\\ {2} & \\text{{otherwise}} \\end{{cases}}"
    ),
    "identity": Form("{0}", 0, (0,)),
    "pi": Form("\\pi"),
    "e": Form("e"),
    "epsilon": Form("\\varepsilon"),
}

LATEX = Notation(
    {**{name: _call(name, f.arity) for name, f in SCALARS.items()}, **_OPERATORS}, _literal, 7
)

"""Bounds on time and memory of mathematics on untrusted text.

The size of a text is bounded by `arael.syntax.limits`; these bound the size of its results.
"""

MAX_NESTING = 150
"""Levels of an expression as written, through the calls of functions."""

MAX_STEPS = 50_000
"""Operations made while one text is read, functions written out."""

MAX_SCALARS = 4096
"""Scalars of one vector or matrix."""

MAX_ALGEBRA = 600
"""Operations, written out, of what `expand` and `collect` take."""

MAX_SIMPLIFY = 200
"""The same of `simplify`, which tries many ways and takes seconds for fifty."""

MAX_TERMS = 5000
"""Terms that `expand` may write out."""

MAX_DEGREE = 200
"""Degree of what `expand`, `collect` and `simplify` take: powers within powers multiply."""

MAX_SUPERSCRIPT = 64
"""Largest whole number that an exponent is treated as exactly by algebra."""

MAX_DERIVATIVES = 16
"""Order of the highest derivative asked for at once."""

MAX_DIFFERENTIATED = 30_000
"""Operations of what is differentiated, each kept once; each derivative is three times as large."""

MAX_DEFINITIONS = 1000
"""Variables and functions that a calculator holds."""

"""Bounds on time and memory of mathematics on untrusted text.

The size of a text is bounded by `arael.syntax.limits`; these bound the size of its results.
"""

MAX_WRITTEN_OUT = 10_000
"""Operations of an expression written out, nothing shared: of what is read, printed, calculated."""

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

MAX_DIFFERENTIATED = 5000
"""Operations, written out, of what `diff` takes; SymPy needs about a millisecond for each."""

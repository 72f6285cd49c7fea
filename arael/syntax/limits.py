"""Limits of the parser for untrusted input.

They are far above hand-written models, and bound time and memory for malicious text: later stages
walk trees recursively and rely on `MAX_HEIGHT`.
"""

MAX_BYTES = 1 << 20
"""Size of a model file."""

MAX_TOKENS = 100_000
"""Tokens in a file."""

MAX_NESTING = 64
"""Depth of brackets within brackets."""

MAX_HEIGHT = 200
"""Height of an expression's tree; a chain of operators such as ``a + b + c`` counts once."""

MAX_STACK = 2000
"""Symbols on the parser's stack before their statement is complete."""

MAX_NAME = 100
"""Characters in a name."""

MAX_NUMBER = 60
"""Characters in a number."""

MAX_ERRORS = 20
"""Syntax errors reported in one run."""

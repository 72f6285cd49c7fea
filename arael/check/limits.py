"""Limits on the size of a model, so that checking and compiling any file takes bounded time.

They are far above the size of hand-written models; a file that exceeds one gets a diagnostic.
"""

MAX_VECTOR = 1024  # scalars of one vector
MAX_MATRIX = 4096  # scalars of one matrix
MAX_TABLES = 1000  # places where collections sit
MAX_COLUMNS = 20_000  # columns of all tables together
MAX_REF_LIST = 32  # refs of one list of refs
MAX_REFS = 50  # refs that one ref is resolved through
MAX_NESTING = 100  # nesting of an expression as written, through function calls; a sum is one level
MAX_EXPANDED = 20_000  # operations that calls of functions add to one constraint or function
MAX_MODEL_EXPANDED = 60_000  # the same over the whole model
MAX_OPERATIONS = 200_000  # scalar operations of one constraint, functions expanded
MAX_MODEL_OPERATIONS = 1_000_000  # the same over the whole model

"""The expression machine: tapes of operations, run without a compiler."""

"""The calculator of `arael calc`, on the formulas of `arael.sym`."""

"""arael: nonlinear least squares from readable model files."""

__version__ = "0.1.0"

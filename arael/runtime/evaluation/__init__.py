"""Cost, gradient and blocks of a problem at given values of its parameters."""

"""Linear solvers for the steps of a solve; `auto.make_solver` is the way in."""

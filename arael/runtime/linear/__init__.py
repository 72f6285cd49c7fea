"""Linear solvers for the steps of a solve; `auto.make_solver` creates them."""

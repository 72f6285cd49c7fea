from arael.runtime.linear.base import LinearSolver

class CholmodSolver(LinearSolver):
    failure: Exception | None

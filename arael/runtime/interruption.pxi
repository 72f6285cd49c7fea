"""Breaking off what takes longer: a flag that any thread sets and loops without the GIL read."""


class InterruptedWork(Exception):
    """What was asked for was broken off; it has no result."""


cdef class Interruption:
    """A request to break off; of any number of solvers and factors, by any thread.

    It lasts until it is withdrawn: all solves of an edit that takes several end by one request.
    """

    def request(self, long long looks=0):
        """Break off what is in progress, before its next step.

        With `looks`, when loops have looked for a request so often: for breaking off at the same
        place again.
        """
        self.looks = looks
        if looks <= 0:
            self.raised = 1

    def withdraw(self):
        """Let work go on."""
        self.looks = 0
        self.raised = 0

    @property
    def requested(self):
        """Whether work is to be broken off."""
        return self.raised != 0

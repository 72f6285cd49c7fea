"""Powell's dogleg."""

class Dogleg:
    """Trust regions whose steps lie on Powell's dogleg."""

    floor: float

    @property
    def radius(self) -> float: ...

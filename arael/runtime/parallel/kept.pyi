"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

class Kept:
    """The first exception that code without a way to raise met."""

    any: bool
    error: BaseException | None

    def again(self) -> None: ...

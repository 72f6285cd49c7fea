from typing import Any

from arael.runtime.linear.reduction import Products, Reduction

class Elimination:
    reduction: Reduction
    n: int
    threads: int
    def __init__(self, reduction: Reduction, dtype: Any) -> None: ...

class Sums:
    products: Products
    def __init__(self, of: Elimination, products: Products, dtype: Any) -> None: ...

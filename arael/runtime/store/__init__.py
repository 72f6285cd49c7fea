"""The columnar database that holds one instance of a model's data."""

from arael.runtime.store.references import Handles
from arael.runtime.store.store import Store
from arael.runtime.store.table import Table

__all__ = ["Handles", "Store", "Table"]

"""Python interface of a model's data: collections, rows, fields and parameters by name."""

from arael.face.collection import Collection
from arael.face.parameter import Parameter
from arael.face.ref import Ref, Refs

__all__ = ["Collection", "Parameter", "Ref", "Refs"]

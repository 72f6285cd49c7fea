"""Compiled models on disk: private to the user, written whole, verified before they are used.

The folder of the cache (`directory`) holds these, and may hold files of the user::

    arael-models/KEY.json    the layout of a model's text, and which kernels belong to it
    arael-kernels/KEY/       generated source, extension module, manifest with their SHA-256
    arael-failed/KEY.log     what the compiler reported; KEY.json: when to try again
    arael-locks/NN.lock      held while kernels are compiled

A model is found in two steps. Its text leads to an entry of the first kind, which depends on
everything in the text, comments and places included. That entry names the generated code, and the
code leads to compiled kernels. A changed comment makes a new entry of the first kind, and finds the
kernels that are there.
"""

from __future__ import annotations

from arael.compiler.cache.keys import code_digest, digest, kernels_key, model_key, shipped_key
from arael.compiler.cache.trust import directory
from arael.compiler.cache.upkeep import Cleared, clear, entries

__all__ = [
    "Cleared",
    "clear",
    "code_digest",
    "digest",
    "directory",
    "entries",
    "kernels_key",
    "model_key",
    "shipped_key",
]

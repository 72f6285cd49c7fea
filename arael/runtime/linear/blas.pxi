"""BLAS and LAPACK from the SciPy wheel, without importing `scipy.linalg`.

`scipy.linalg.cython_blas` and `cython_lapack` export pointers to every routine for compiled code. A
normal import runs ``scipy/linalg/__init__.py`` first, which takes a tenth of a second. Therefore
the two extension modules are loaded by file, or by name if that fails.
"""

import os
import sys
from importlib import import_module
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import find_spec, module_from_spec, spec_from_file_location

from cpython.pycapsule cimport PyCapsule_GetName, PyCapsule_GetPointer

cdef bint loaded = False


def is_blas_loaded():
    """Whether a solver has loaded BLAS in this process."""
    return bool(loaded)


def _extension(name):
    """Module `scipy.linalg.<name>`, loaded without its package if possible."""
    full = f"scipy.linalg.{name}"
    if full in sys.modules:
        return sys.modules[full]
    spec = find_spec("scipy")
    for root in spec.submodule_search_locations or () if spec else ():
        for suffix in EXTENSION_SUFFIXES:
            path = os.path.join(root, "linalg", name + suffix)
            if os.path.exists(path):
                spec = spec_from_file_location(full, path)
                module = module_from_spec(spec)
                try:
                    spec.loader.exec_module(module)
                except ImportError:
                    break
                return module
    return import_module(full)


cdef void* _pointer(module, str name, int arguments) except NULL:
    """Address of routine `name`, after a check of its number of arguments."""
    capsule = module.__pyx_capi__[name]
    cdef const char* signature = PyCapsule_GetName(capsule)
    text = signature.decode()
    letter = "_" + name[0] + " *"
    if not text.startswith("void (") or text.count(",") + 1 != arguments or letter not in text:
        raise ImportError(f"scipy's {name} has the unexpected signature {text!r}")
    return PyCapsule_GetPointer(capsule, signature)


def load_blas():
    """Fill the pointers of this module; cheap after the first call.

    Raises
    ------
    ImportError
        If SciPy is missing or its routines have other signatures.
    """
    global loaded, dgemm, sgemm, dsyrk, ssyrk, dtrsm, strsm, dtrsv, strsv, dgemv, sgemv
    global dpotrf, spotrf, dpotrs, spotrs, dpbtrf, spbtrf, dpbtrs, spbtrs
    if loaded:
        return
    b = _extension("cython_blas")
    dgemm, sgemm = <dgemm_t>_pointer(b, "dgemm", 13), <sgemm_t>_pointer(b, "sgemm", 13)
    dsyrk, ssyrk = <dsyrk_t>_pointer(b, "dsyrk", 10), <ssyrk_t>_pointer(b, "ssyrk", 10)
    dtrsm, strsm = <dtrsm_t>_pointer(b, "dtrsm", 11), <strsm_t>_pointer(b, "strsm", 11)
    dtrsv, strsv = <dtrsv_t>_pointer(b, "dtrsv", 8), <strsv_t>_pointer(b, "strsv", 8)
    dgemv, sgemv = <dgemv_t>_pointer(b, "dgemv", 11), <sgemv_t>_pointer(b, "sgemv", 11)
    p = _extension("cython_lapack")
    dpotrf, spotrf = <dpotrf_t>_pointer(p, "dpotrf", 5), <spotrf_t>_pointer(p, "spotrf", 5)
    dpotrs, spotrs = <dpotrs_t>_pointer(p, "dpotrs", 8), <spotrs_t>_pointer(p, "spotrs", 8)
    dpbtrf, spbtrf = <dpbtrf_t>_pointer(p, "dpbtrf", 6), <spbtrf_t>_pointer(p, "spbtrf", 6)
    dpbtrs, spbtrs = <dpbtrs_t>_pointer(p, "dpbtrs", 9), <spbtrs_t>_pointer(p, "spbtrs", 9)
    loaded = True

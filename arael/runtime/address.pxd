# Where the scalars of an array are, for kernels that take pointers.
#
# The only way from an array to a pointer: what the cast at the call assumes is checked here, since
# an array of another type or order would be read as numbers that look like a result.
#
# It reads the fields of the array itself: a buffer makes NumPy describe the array in words first,
# which takes four times as long, and a first solve asks some hundred times.

from cpython.object cimport PyObject
from numpy cimport (
    NPY_ARRAY_C_CONTIGUOUS, NPY_ARRAY_WRITEABLE, PyArray_CHKFLAGS, PyArray_DATA, PyArray_DIMS,
    PyArray_NDIM, ndarray,
)


cdef extern from *:
    """
    #define scalar_type(array) ((PyObject *)PyArray_DESCR((PyArrayObject *)(array))->typeobj)
    """
    PyObject* scalar_type(ndarray array) noexcept


cdef inline Py_ssize_t scalars_of(ndarray array) noexcept:
    """Number of scalars of an array; its attribute `size` makes an object of it."""
    cdef Py_ssize_t found = 1
    cdef int k
    for k in range(PyArray_NDIM(array)):
        found *= PyArray_DIMS(array)[k]
    return found


cdef inline void* _first(array, dtype, Py_ssize_t least, bint write) except? NULL:
    if not isinstance(array, ndarray):
        raise TypeError(f"expected an array, found {type(array).__name__}")
    cdef ndarray one = <ndarray>array
    # Scalar types first: comparing dtypes takes longer, and there may be hundreds of arrays.
    if scalar_type(one) != <PyObject*>dtype and array.dtype != dtype:
        raise TypeError(f"expected an array of {dtype}, found {array.dtype}")
    if scalars_of(one) < least:
        raise ValueError(f"expected at least {least} scalars, found {scalars_of(one)}")
    if not PyArray_CHKFLAGS(one, NPY_ARRAY_C_CONTIGUOUS):
        raise ValueError("expected an array that is contiguous in C order")
    if write and not PyArray_CHKFLAGS(one, NPY_ARRAY_WRITEABLE):
        raise ValueError("expected an array that is written to, found a read-only one")
    return PyArray_DATA(one)


cdef inline const void* address(array, dtype, Py_ssize_t least=0) except? NULL:
    """First byte of an array that is read, which the caller keeps.

    Raises TypeError for another dtype, ValueError for fewer than `least` scalars or an array that
    is not contiguous in C order.
    """
    return _first(array, dtype, least, False)


cdef inline void* writable(array, dtype, Py_ssize_t least=0) except? NULL:
    """First byte of an array that is written to; as `address`, and read-only arrays are refused."""
    return _first(array, dtype, least, True)


cdef inline const void* table_address(array, Py_ssize_t columns) except? NULL:
    """First byte of a table (rows, columns) of int64 whose rows C code reads by position."""
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"expected a table of {columns} columns, found shape {array.shape}")
    return address(array, "int64")

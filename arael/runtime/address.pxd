# Where the scalars of an array are, for kernels that take pointers.
#
# The only way from an array to a pointer: what the cast at the call assumes is checked here, since
# an array of another type or order would be read as numbers that look like a result.

from cpython.buffer cimport PyBUF_SIMPLE, PyBUF_WRITABLE, PyBuffer_Release, PyObject_GetBuffer


cdef inline void* _first(array, dtype, Py_ssize_t least, int flags) except? NULL:
    cdef Py_buffer view
    # Scalar types first: comparing dtypes takes longer, and there may be hundreds of arrays.
    if array.dtype.type is not dtype and array.dtype != dtype:
        raise TypeError(f"expected an array of {dtype}, found {array.dtype}")
    if array.size < least:
        raise ValueError(f"expected at least {least} scalars, found {array.size}")
    # Ten times as fast as `array.ctypes.data`. A simple buffer is contiguous in C order.
    PyObject_GetBuffer(array, &view, flags)
    cdef void* found = view.buf
    PyBuffer_Release(&view)
    return found


cdef inline const void* address(array, dtype, Py_ssize_t least=0) except? NULL:
    """First byte of an array that is read, which the caller keeps.

    Raises TypeError for another dtype, ValueError for fewer than `least` scalars or an array that
    is not contiguous in C order.
    """
    return _first(array, dtype, least, PyBUF_SIMPLE)


cdef inline void* writable(array, dtype, Py_ssize_t least=0) except? NULL:
    """First byte of an array that is written to; as `address`, and read-only arrays are refused."""
    return _first(array, dtype, least, PyBUF_WRITABLE)


cdef inline const void* table_address(array, Py_ssize_t columns) except? NULL:
    """First byte of a table (rows, columns) of int64 whose rows C code reads by position."""
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"expected a table of {columns} columns, found shape {array.shape}")
    return address(array, "int64")

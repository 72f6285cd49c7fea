# Where the scalars of an array are.

from cpython.buffer cimport PyBUF_SIMPLE, PyBuffer_Release, PyObject_GetBuffer


cdef inline const void* address(array) except? NULL:
    """First byte of a contiguous array, which the caller keeps."""
    cdef Py_buffer view
    # Ten times as fast as `array.ctypes.data`: there are many arrays, and most are small.
    PyObject_GetBuffer(array, &view, PyBUF_SIMPLE)
    cdef const void* found = view.buf
    PyBuffer_Release(&view)
    return found

# Memory of the runtime's own as bytes that NumPy can take: np.frombuffer(bytes_at(...), dtype).
# Cython's way, a cast of the pointer to a memoryview, copies its array type into the module.

from cpython.buffer cimport PyBUF_WRITE
from cpython.memoryview cimport PyMemoryView_FromMemory


cdef inline object bytes_at(const void* memory, Py_ssize_t count):
    """Some bytes of memory that outlives whatever reads them."""
    return PyMemoryView_FromMemory(<char*>memory, count, PyBUF_WRITE)

"""Unknowns and constants as kernels read them: as rows of entities at any offset."""

import numpy as np

from arael.runtime.address cimport address
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy


cdef class UnknownWindows:
    """Flat unknowns, and behind them constants at negative offsets, as states of entities.

    An entity of w scalars may begin at any offset, but kernels multiply the number of a row by w.
    For each w there is therefore an array of windows: row k consists of the scalars k .. k + w - 1.

    Parameters
    ----------
    n : int
        Unknowns.
    widths : iterable of int
        Scalars of the entities, 1 to 8.

    Attributes
    ----------
    n : int
    constants : int
        Scalars behind the constants' offsets, unused blocks included.
    """

    def __init__(self, Py_ssize_t n, widths):
        self._lengths, self._spare = {}, {}
        self.n, self._capacity, self._constant_capacity = n, max(n, 16), 16
        for width in {1, *widths}:
            if not 1 <= width <= MOST_WIDTH:
                raise ValueError(f"expected entities of 1 to {MOST_WIDTH} scalars, found {width}")
            self._memory[<Py_ssize_t>width] = allocated(
                width, self._capacity + self._constant_capacity)

    def __dealloc__(self):
        cdef Py_ssize_t width
        for width in range(MOST_WIDTH + 1):
            free(self._memory[width])

    cdef const double* of_width(self, Py_ssize_t width) noexcept nogil:
        return self._memory[width] + width * self._constant_capacity

    cdef void fill(self, const double* x) noexcept nogil:
        """Bring the unknowns into all windows."""
        cdef Py_ssize_t width, k, j
        cdef double* to = self._memory[1] + self._constant_capacity
        cdef const double* source = to
        memcpy(to, x, self.n * sizeof(double))
        for width in range(2, MOST_WIDTH + 1):
            if self._memory[width] == NULL:
                continue
            to = self._memory[width] + width * self._constant_capacity
            if width == 2:
                for k in range(self.n):
                    to[2 * k] = source[k]
                    to[2 * k + 1] = source[k + 1]
            else:
                for k in range(self.n):
                    for j in range(width):
                        to[width * k + j] = source[k + j]

    cdef void put(self, Py_ssize_t at, double value) noexcept nogil:
        """Bring one unknown into all windows."""
        cdef Py_ssize_t width, j
        cdef double* to
        for width in range(1, MOST_WIDTH + 1):
            if self._memory[width] == NULL:
                continue
            to = self._memory[width] + width * self._constant_capacity
            for j in range(width):
                to[width * (at - j) + j] = value

    cdef bint holds(self, Py_ssize_t offset, Py_ssize_t width) noexcept nogil:
        """Whether an entity of so many scalars may begin there."""
        if offset < 0:
            return offset >= -self.constants and offset + width <= 0
        return offset + width <= self.n

    def resize(self, Py_ssize_t n):
        """Change the number of unknowns."""
        if n > self._capacity:
            self._grow(max(n, 2 * self._capacity), self._constant_capacity)
        self.n = n

    def take(self, values):
        """Offset (negative) of a block of constants with these values."""
        values = np.ascontiguousarray(values, dtype=np.float64).ravel()
        length = len(values)
        if not length:
            raise ValueError("expected at least one constant, found none")
        spare = self._spare.get(length)
        if spare:
            offset = spare.pop()
        else:
            if self.constants + length > self._constant_capacity:
                self._grow(self._capacity, max(2 * self._constant_capacity, 2 * length))
            self.constants += length
            offset = -self.constants
        self._lengths[offset] = length
        self.set(offset, values)
        return offset

    def release(self, offset):
        """Free a block of constants."""
        if offset not in self._lengths:
            raise ValueError(f"expected the offset of a block of constants, found {offset}")
        self._spare.setdefault(self._lengths.pop(offset), []).append(offset)

    def set(self, offset, values):
        """Change the values of a block of constants."""
        cdef Py_ssize_t first = offset, k
        cdef double* to
        values = np.ascontiguousarray(values, dtype=np.float64).ravel()
        cdef const double* source = <const double*>address(values, np.float64)
        if self._lengths.get(offset) != len(values):
            raise ValueError(
                f"expected {self._lengths.get(offset, 0)} constants at offset {offset}, "
                f"found {len(values)}")
        to = self._memory[1] + self._constant_capacity
        for k in range(len(values)):
            to[first + k] = source[k]
        self._windows(first - MOST_WIDTH, first + <Py_ssize_t>len(values))

    def values(self, offset):
        """The values of a block of constants."""
        cdef Py_ssize_t first = offset
        cdef const double* source = self._memory[1] + self._constant_capacity
        return np.array([source[first + k] for k in range(self._lengths[offset])])

    cdef _windows(self, Py_ssize_t begin, Py_ssize_t end):
        """Bring constants from `begin` to `end` into windows that are wider than one scalar."""
        cdef Py_ssize_t width, k, j
        cdef double* to
        cdef const double* source = self._memory[1] + self._constant_capacity
        for width in range(2, MOST_WIDTH + 1):
            if self._memory[width] == NULL:
                continue
            to = self._memory[width] + width * self._constant_capacity
            for k in range(max(begin, -self._constant_capacity), end):
                for j in range(width):
                    to[width * k + j] = source[k + j]

    cdef _grow(self, Py_ssize_t capacity, Py_ssize_t constants):
        cdef Py_ssize_t width
        cdef double* memory
        for width in range(1, MOST_WIDTH + 1):
            if self._memory[width] == NULL:
                continue
            memory = allocated(width, capacity + constants)
            memcpy(memory + width * (constants - self._constant_capacity), self._memory[width],
                   width * (self._constant_capacity + self._capacity) * sizeof(double))
            free(self._memory[width])
            self._memory[width] = memory
        self._capacity, self._constant_capacity = capacity, constants


cdef double* allocated(Py_ssize_t width, Py_ssize_t rows) except NULL:
    """Zeros for so many windows; the last ones read beyond the unknowns."""
    cdef double* memory = <double*>calloc(width * rows + MOST_WIDTH, sizeof(double))
    if memory == NULL:
        raise MemoryError
    return memory

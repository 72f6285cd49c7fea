"""Single passes over numbers that share unknowns: what every solve of a sketch does once or twice.

A document has numbers, a system has unknowns; several numbers may be one unknown (`root` is their
index in x), or none (-1). Each pass takes a microsecond where a dozen calls of NumPy take twenty.
"""

import numpy as np

from libc.math cimport INFINITY, fabs, isfinite
from libc.stdint cimport int32_t, int64_t
from libc.string cimport memcmp

from arael.runtime.address cimport address, writable


def differs(values, others, at):
    """Whether numbers at the indices `at` (k,) differ in any bit from `others` there."""
    cdef const double* one = <const double*>address(values, np.float64)
    cdef const double* other = <const double*>address(others, np.float64)
    cdef const int64_t* index = <const int64_t*>address(at, np.int64)
    cdef Py_ssize_t k, count = at.size
    for k in range(count):
        if memcmp(one + index[k], other + index[k], sizeof(double)) != 0:
            return True
    return False


def gather(values, source, x):
    """Set x[i] to values[source[i]] for every i with a source; those of -1 stay."""
    cdef const double* number = <const double*>address(values, np.float64)
    cdef const int64_t* of = <const int64_t*>address(source, np.int64)
    cdef Py_ssize_t i, count = source.size
    cdef double* to = <double*>writable(x, np.float64, count)
    for i in range(count):
        if of[i] >= 0:
            to[i] = number[of[i]]


def spread(kinds, root, found):
    """Set found[root[i]] to kinds[i] for every i whose kind (int8) is not 0."""
    cdef const signed char* kind = <const signed char*>address(kinds, np.int8)
    cdef Py_ssize_t i, count = kinds.size
    cdef const int64_t* of = <const int64_t*>address(root, np.int64, count)
    cdef signed char* to = <signed char*>writable(found, np.int8)
    for i in range(count):
        if kind[i] != 0:
            to[of[i]] = kind[i]


def scattered(x, root, values, at):
    """Numbers that differ in any bit from the unknown that they share.

    Parameters
    ----------
    x : (n,) float64
        Unknowns.
    root : (N,) int64
        Index in x of each number.
    values : (>= N,) float64
        Numbers.
    at : (k,) int64
        Indices of the numbers that are compared.

    Returns
    -------
    indices, old, new : arrays
        (c,) int64 from `at`, in its order, and float64 from `values` and x.

    Raises
    ------
    ValueError
        If an unknown is not finite.
    """
    cdef const double* unknown = <const double*>address(x, np.float64)
    cdef const int64_t* of = <const int64_t*>address(root, np.int64)
    cdef const double* number = <const double*>address(values, np.float64)
    cdef const int64_t* index = <const int64_t*>address(at, np.int64)
    cdef Py_ssize_t k, i, found = 0, count = at.size
    for k in range(count):
        i = index[k]
        if memcmp(number + i, unknown + of[i], sizeof(double)) != 0:
            found += 1
            if not isfinite(unknown[of[i]]):
                raise ValueError("the numbers of a sketch are finite")
    indices, old, new = np.empty(found, np.int64), np.empty(found), np.empty(found)
    cdef int64_t* to = <int64_t*>writable(indices, np.int64)
    cdef double* before = <double*>writable(old, np.float64)
    cdef double* after = <double*>writable(new, np.float64)
    found = 0
    for k in range(count):
        i = index[k]
        if memcmp(number + i, unknown + of[i], sizeof(double)) != 0:
            to[found], before[found], after[found] = i, number[i], unknown[of[i]]
            found += 1
    return indices, old, new


def put(values, at, numbers):
    """Set values[at[k]] to numbers[k]."""
    cdef double* to = <double*>writable(values, np.float64)
    cdef const int64_t* index = <const int64_t*>address(at, np.int64)
    cdef Py_ssize_t k, count = at.size
    cdef const double* of = <const double*>address(numbers, np.float64, count)
    for k in range(count):
        to[index[k]] = of[k]


def named(at, first, list names):
    """Names of runs of `at`: names[first[i]] for each i whose first differs from the last one's."""
    cdef const int64_t* index = <const int64_t*>address(at, np.int64)
    cdef const int64_t* begin = <const int64_t*>address(first, np.int64)
    cdef Py_ssize_t k, count = at.size
    cdef int64_t last = -1, now
    found = []
    for k in range(count):
        now = begin[index[k]]
        if now != last:
            found.append(names[now])
            last = now
    return tuple(found)


def near(values, at, double x, double y, double distance):
    """Numbers k of the points (x at values[at[k]], y behind it) within a distance of a place."""
    cdef const double* number = <const double*>address(values, np.float64)
    cdef const int64_t* point = <const int64_t*>address(at, np.int64)
    cdef Py_ssize_t k, count = at.size
    cdef double dx, dy
    found = []
    for k in range(count):
        dx, dy = number[point[k]] - x, number[point[k] + 1] - y
        if dx * dx + dy * dy <= distance * distance:
            found.append(k)
    return found


def mostly_apart(values, double least):
    """Whether more than half of the differences of neighbours are not below `least`.

    Then their median is not below it either: it need not be sorted for.
    """
    cdef const double* number = <const double*>address(values, np.float64)
    cdef Py_ssize_t i, count = values.size - 1, apart = 0
    for i in range(count):
        if fabs(number[i + 1] - number[i]) >= least:
            apart += 1
    return 2 * apart > count


def largest(values):
    """Largest magnitude; 0 of none."""
    cdef const double* number = <const double*>address(values, np.float64)
    cdef Py_ssize_t i, count = values.size
    cdef double found = 0.0
    for i in range(count):
        found = max(found, fabs(number[i]))
    return found


def extent(values, points, lengths):
    """Largest side of the box around points, or twice the largest length.

    Parameters
    ----------
    values : (N,) float64
    points : (p,) int64
        Where the x of each point is; its y follows.
    lengths : (l,) int64
        Where lengths are; their signs do not matter.
    """
    cdef const double* number = <const double*>address(values, np.float64)
    cdef const int64_t* point = <const int64_t*>address(points, np.int64)
    cdef const int64_t* length = <const int64_t*>address(lengths, np.int64)
    cdef Py_ssize_t k, count = points.size
    cdef double left = INFINITY, right = -INFINITY, low = INFINITY, high = -INFINITY
    cdef double found = 0.0, x, y
    for k in range(count):
        x, y = number[point[k]], number[point[k] + 1]
        left, right = min(left, x), max(right, x)
        low, high = min(low, y), max(high, y)
    if count:
        found = max(right - left, high - low)
    count = lengths.size
    for k in range(count):
        found = max(found, 2.0 * fabs(number[length[k]]))
    return found


def any_short(values, lines, lengths, double least):
    """Whether a line (x1 y1 x2 y2 from each index of `lines`) or a length is not above `least`."""
    cdef const double* number = <const double*>address(values, np.float64)
    cdef const int64_t* at = <const int64_t*>address(lines, np.int64)
    cdef const int64_t* length = <const int64_t*>address(lengths, np.int64)
    cdef const double* p
    cdef Py_ssize_t k, count = lines.size
    cdef double dx, dy
    for k in range(count):
        p = number + at[k]
        dx, dy = fabs(p[2] - p[0]), fabs(p[3] - p[1])
        # The longer leg is no longer than the line: mostly no root is needed.
        if not max(dx, dy) > least and not dx * dx + dy * dy > least * least:
            return True
    count = lengths.size
    for k in range(count):
        if not number[length[k]] > least:
            return True
    return False


cdef class ComponentSizes:
    """Sizes of components, and from them tolerances of their rows.

    The size of a component is the larger side of the box around its points, or its largest length;
    of one without extent, that of the largest component.

    Parameters
    ----------
    axes : (n,) int8
        What each unknown is: 1 an x, 2 a y, 3 a length; anything else does not count.
    of_unknown, of_row : (n,), (m,) int32
        Components, from 0.
    """

    cdef object _axis, _of, _rows, _work
    cdef const int64_t* _at
    cdef Py_ssize_t _count, _parts, _m
    cdef readonly Py_ssize_t n

    def __init__(self, axes, of_unknown, of_row):
        cdef Py_ssize_t i, c
        self.n, self._m, self._count, self._parts = len(axes), len(of_row), 0, 0
        cdef const char* axis = <const char*>address(axes, np.int8)
        cdef const int32_t* label = <const int32_t*>address(of_unknown, np.int32, self.n)
        cdef const int32_t* of = <const int32_t*>address(of_row, np.int32)
        self._rows, self._of = np.empty(self._m, np.int64), np.empty(3 * self.n, np.int64)
        cdef int64_t* row = <int64_t*>writable(self._rows, np.int64)
        cdef int64_t* to = <int64_t*>writable(self._of, np.int64)
        # Components of rows by number; an unknown without rows is one by itself.
        most = max(int(np.max(of_unknown, initial=-1)), int(np.max(of_row, initial=-1)))
        numbers = np.full(most + 1, -1, np.int32)
        cdef int32_t* number = <int32_t*>writable(numbers, np.int32)
        for i in range(self._m):
            if number[of[i]] < 0:
                number[of[i]] = <int32_t>self._parts
                self._parts += 1
            row[i] = number[of[i]]
        # Index of the unknown, its component, its kind. Of what has no rows lengths alone have a
        # size; these are one component together, the last.
        for i in range(self.n):
            if axis[i] < 1 or axis[i] > 3:
                continue
            c = number[label[i]] if number[label[i]] >= 0 else self._parts
            if c < self._parts or axis[i] == 3:
                to[3 * self._count], to[3 * self._count + 1] = i, c
                to[3 * self._count + 2] = axis[i]
                self._count += 1
        self._parts += 1
        self._at = to
        # Low and high of x and y, largest magnitude of all, largest length.
        self._work = np.empty((self._parts, 6))

    def tolerances(self, x, double relative, double rounding, whole):
        """Tolerances of all rows, (m,), with the unknowns at `x`, (n,).

        Parameters
        ----------
        relative : of the component's size
        rounding : of its largest number; the tolerance is no smaller
        whole : callable; the size where no component has one
        """
        cdef const double* unknown = <const double*>address(x, np.float64, self.n)
        cdef double* work = <double*>writable(self._work, np.float64)
        cdef const int64_t* row = <const int64_t*>address(self._rows, np.int64)
        cdef Py_ssize_t k, c
        cdef int64_t kind
        cdef double v, size, top = 0.0
        cdef double* p
        for c in range(self._parts):
            p = work + 6 * c
            p[0] = p[2] = INFINITY
            p[1] = p[3] = -INFINITY
            p[4] = p[5] = 0.0
        for k in range(self._count):
            v = unknown[self._at[3 * k]]
            p = work + 6 * self._at[3 * k + 1]
            kind = self._at[3 * k + 2]
            p[4] = max(p[4], fabs(v))
            if kind == 3:
                p[5] = max(p[5], fabs(v))
            elif kind == 2:
                p[2], p[3] = min(p[2], v), max(p[3], v)
            else:
                p[0], p[1] = min(p[0], v), max(p[1], v)
        for c in range(self._parts):
            p = work + 6 * c
            size = p[5]
            if p[1] >= p[0]:
                size = max(size, p[1] - p[0])
            if p[3] >= p[2]:
                size = max(size, p[3] - p[2])
            p[5] = size
            top = max(top, size)
        if top == 0.0:
            top = whole()
        for c in range(self._parts):
            p = work + 6 * c
            size = top if p[5] <= 1e-9 * top else p[5]
            p[0] = max(relative * size, rounding * p[4])
        found = np.empty(self._m)
        cdef double* to = <double*>writable(found, np.float64)
        for k in range(self._m):
            to[k] = work[6 * row[k]]
        return found

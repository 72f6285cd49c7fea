# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Arithmetic per edge and per pose of a pose graph, in loops over f64 arrays.

Formulas and their sources are in `chordal.py`, `relaxation.py` and `arael.runtime.store.rotations`.
"""

import numpy as np

from libc.math cimport atan2, cos, isfinite, sin, sqrt
from libc.stdint cimport int64_t, uint8_t

from arael.runtime.address cimport address, writable


cdef enum:
    ROUNDS = 30         # of Newton's iteration for the polar factor

cdef double FLAT = 1e-6     # of a matrix whose determinant is so small, by the cube of its norm


cdef const double* reals(array, Py_ssize_t least=0) except? NULL:
    return <const double*>address(array, np.float64, least)


cdef const int64_t* ints(array, Py_ssize_t least=0) except? NULL:
    return <const int64_t*>address(array, np.int64, least)


cdef double* filled(array) except? NULL:
    return <double*>writable(array, np.float64)


cdef inline void product(
    const double* a, const double* b, double* c, Py_ssize_t d, bint turned
) noexcept nogil:
    """c = a b, or a' b if `turned`; all d x d by rows."""
    cdef Py_ssize_t i, j, k
    cdef double total
    for i in range(d):
        for j in range(d):
            total = 0
            for k in range(d):
                total += (a[k * d + i] if turned else a[i * d + k]) * b[k * d + j]
            c[i * d + j] = total


cdef inline void product_turned(
    const double* a, const double* b, double* c, Py_ssize_t d
) noexcept nogil:
    """c = a b'."""
    cdef Py_ssize_t i, j, k
    cdef double total
    for i in range(d):
        for j in range(d):
            total = 0
            for k in range(d):
                total += a[i * d + k] * b[j * d + k]
            c[i * d + j] = total


def all_there(from_rows, to_rows):
    """Whether all (m,) int64 rows of both ends of edges are there: none is negative."""
    cdef Py_ssize_t m = len(from_rows), e
    cdef const int64_t* a = ints(from_rows)
    cdef const int64_t* b = ints(to_rows, m)
    for e in range(m):
        if a[e] < 0 or b[e] < 0:
            return False
    return True


def information_of(factor):
    """Information matrices of edges, and whether positions and rotations are coupled in any.

    Parameters
    ----------
    factor : (m, k, k) upper Cholesky factors u

    Returns
    -------
    information : (m, k, k), u' u
    coupled : bool
    """
    cdef Py_ssize_t m = factor.shape[0], k = factor.shape[1], d = 2 if k == 3 else 3, _, i, j, r
    cdef const double* u = reals(factor, m * k * k)
    found = np.empty((m, k, k))
    cdef double* to = filled(found)
    cdef double total
    cdef bint coupled = False
    with nogil:
        for _ in range(m):
            for i in range(k):
                for j in range(i + 1):
                    total = 0
                    for r in range(k):
                        total += u[r * k + i] * u[r * k + j]
                    to[i * k + j] = to[j * k + i] = total
                    if total != 0 and i >= d and j < d:
                        coupled = True
            u += k * k
            to += k * k
    return found, coupled


cdef inline bint solved_triangle(
    const double* matrix, Py_ssize_t stride, double* factor, Py_ssize_t d, double least
) noexcept nogil:
    """Lower Cholesky factor of the leading d x d of a matrix; False if a pivot is below `least`."""
    cdef Py_ssize_t i, j, k
    cdef double total
    for j in range(d):
        for i in range(j, d):
            total = matrix[i * stride + j]
            for k in range(j):
                total -= factor[i * d + k] * factor[j * d + k]
            if i > j:
                factor[i * d + j] = total / factor[j * d + j]
            elif total > least:
                factor[j * d + j] = sqrt(total)
            else:
                return False
    return True


def marginal_of(information):
    """Information of rotations alone: the Schur complement of the positions.

    Parameters
    ----------
    information : (m, k, k)

    Returns
    -------
    marginal : (m, r, r)
    left : (m,) bool, edges that are not computed, since their positions are hardly measured; None:
        there are none
    """
    cdef Py_ssize_t m = information.shape[0], k = information.shape[1]
    cdef Py_ssize_t d = 2 if k == 3 else 3, r = k - d, e, i, j, c
    cdef const double* w = reals(information, m * k * k)
    found, left = np.empty((m, r, r)), np.zeros(m, dtype=np.uint8)
    cdef double* to = filled(found)
    cdef uint8_t* out = <uint8_t*>writable(left, np.uint8)
    cdef double[9] factor, mixed
    cdef double most
    cdef bint some = False
    with nogil:
        for e in range(m):
            most = 0
            for i in range(d):
                most = max(most, w[i * k + i])
            out[e] = not solved_triangle(w, k, factor, d, FLAT * most)
            some |= out[e]
            if not out[e]:
                for c in range(r):      # forward substitution of the coupling's columns
                    for i in range(d):
                        mixed[i * r + c] = w[i * k + d + c]
                        for j in range(i):
                            mixed[i * r + c] -= factor[i * d + j] * mixed[j * r + c]
                        mixed[i * r + c] /= factor[i * d + i]
                for i in range(r):
                    for j in range(r):
                        to[i * r + j] = w[(d + i) * k + d + j]
                        for c in range(d):
                            to[i * r + j] -= mixed[c * r + i] * mixed[c * r + j]
            w += k * k
            to += r * r
    return found, left.view(np.bool_) if some else None


def spatial_weights(information, double least):
    """Weights ``tr(W) / 2 I - W`` of chordal residuals in space.

    Parameters
    ----------
    information : (m, 3, 3) of rotations
    least : part of the trace below which no eigenvalue of a weight should be

    Returns
    -------
    weight : (m, 3, 3)
    below : (m,) bool, weights with an eigenvalue below that, or nearly; None: there are none
    """
    cdef Py_ssize_t m = len(information), e, i
    cdef const double* w = reals(information, 9 * m)
    found, below = np.empty((m, 3, 3)), np.zeros(m, dtype=np.uint8)
    cdef double* to = filled(found)
    cdef uint8_t* out = <uint8_t*>writable(below, np.uint8)
    cdef double trace
    cdef double[9] shifted, factor
    cdef bint some = False
    with nogil:
        for e in range(m):
            trace = w[0] + w[4] + w[8]
            for i in range(9):
                to[i] = 0.5 * trace * (i % 4 == 0) - w[i]
                shifted[i] = to[i] - least * trace * (i % 4 == 0)
            # All eigenvalues are above the limit if what is left without it is positive definite.
            out[e] = not solved_triangle(shifted, 3, factor, 3, 0)
            some |= out[e]
            w += 9
            to += 9
    return found, below.view(np.bool_) if some else None


def planar(angle):
    """(n,) angles -> (n, 2, 2) rotations."""
    angle = np.ascontiguousarray(angle, dtype=np.float64)
    cdef Py_ssize_t n = len(angle), k
    cdef const double* a = reals(angle)
    found = np.empty((n, 2, 2))
    cdef double* to = filled(found)
    for k in range(n):
        to[4 * k] = to[4 * k + 3] = cos(a[k])
        to[4 * k + 2] = sin(a[k])
        to[4 * k + 1] = -to[4 * k + 2]
    return found


def angles(rotation):
    """(n, 2, 2) rotations -> (n,) angles in [-pi, pi]."""
    rotation = np.ascontiguousarray(rotation, dtype=np.float64)
    cdef Py_ssize_t n = len(rotation), k
    cdef const double* r = reals(rotation, 4 * n)
    found = np.empty(n)
    cdef double* to = filled(found)
    for k in range(n):
        to[k] = atan2(r[4 * k + 2], r[4 * k])
    return found


def matrices(quaternion):
    """(n, 4) unit quaternions, scalar first -> (n, 3, 3) rotations."""
    quaternion = np.ascontiguousarray(quaternion, dtype=np.float64)
    cdef Py_ssize_t n = len(quaternion), k
    cdef const double* q = reals(quaternion, 4 * n)
    found = np.empty((n, 3, 3))
    cdef double* to = filled(found)
    cdef double w, x, y, z
    for k in range(n):
        w, x, y, z = q[4 * k], q[4 * k + 1], q[4 * k + 2], q[4 * k + 3]
        to[0], to[1], to[2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
        to[3], to[4], to[5] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
        to[6], to[7], to[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
        to += 9
    return found


cdef inline void quaternion_of(const double* m, double* q) noexcept nogil:
    """Unit quaternion with w >= 0 of a rotation (Shepperd 1978)."""
    cdef double a = m[0], b = m[4], c = m[8]
    cdef double ww = 1 + a + b + c, xx = 1 + a - b - c, yy = 1 - a + b - c, zz = 1 - a - b + c
    cdef double wx = m[7] - m[5], wy = m[2] - m[6], wz = m[3] - m[1]
    cdef double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7], length
    cdef Py_ssize_t i
    if ww >= xx and ww >= yy and ww >= zz:
        q[0], q[1], q[2], q[3] = ww, wx, wy, wz
    elif xx >= yy and xx >= zz:
        q[0], q[1], q[2], q[3] = wx, xx, xy, xz
    elif yy >= zz:
        q[0], q[1], q[2], q[3] = wy, xy, yy, yz
    else:
        q[0], q[1], q[2], q[3] = wz, xz, yz, zz
    length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    if q[0] < 0:
        length = -length
    for i in range(4):
        q[i] /= length


def quaternions(rotation):
    """(n, 3, 3) rotations -> (n, 4) unit quaternions with w >= 0, scalar first."""
    rotation = np.ascontiguousarray(rotation, dtype=np.float64)
    cdef Py_ssize_t n = len(rotation), k
    cdef const double* r = reals(rotation, 9 * n)
    found = np.empty((n, 4))
    cdef double* to = filled(found)
    for k in range(n):
        quaternion_of(r + 9 * k, to + 4 * k)
    return found


def rotation_blocks(step, weight):
    """Blocks of the normal equations of ``X_b - Rm' X_a`` with the weight of its rows.

    Parameters
    ----------
    step : (m, d, d) measured rotations Rm
    weight : (m, d, d)

    Returns
    -------
    (m, d, d) each: of `a` with `a`, of `a` with `b`, of `b` with `b`
    """
    cdef Py_ssize_t m = step.shape[0], d = step.shape[1], _, i
    cdef const double* r = reals(step, m * d * d)
    cdef const double* w = reals(weight, m * d * d)
    first, mixed = np.empty((m, d, d)), np.empty((m, d, d))
    cdef double* aa = filled(first)
    cdef double* ab = filled(mixed)
    for _ in range(m):
        product(r, w, ab, d, False)
        product_turned(ab, r, aa, d)
        for i in range(d * d):
            ab[i] = -ab[i]
        r += d * d
        w += d * d
        aa += d * d
        ab += d * d
    return first, mixed, weight


def position_blocks(measured, position, information, rotation, from_rows, to_rows):
    """Blocks and right-hand sides of the quadratic in positions at given rotations.

    Parameters
    ----------
    measured, position : (m, d, d) and (m, d), measured rotations and positions
    information : (m, k, k)
    rotation : (n, d, d), of the poses
    from_rows, to_rows : (m,) int64, poses a and b of each edge

    Returns
    -------
    block : (m, d, d), of `a` with `a` and of `b` with `b`; the negative of `a` with `b`
    pull : (m, d), right-hand side of `b`, the negative of that of `a`
    """
    cdef Py_ssize_t m = measured.shape[0], d = measured.shape[1], k = information.shape[1]
    cdef Py_ssize_t n = len(rotation), e, i, j
    cdef const double* step = reals(measured, m * d * d)
    cdef const double* shift = reals(position, m * d)
    cdef const double* info = reals(information, m * k * k)
    cdef const double* turn_of = reals(rotation, n * d * d)
    cdef const int64_t* a = ints(from_rows, m)
    cdef const int64_t* b = ints(to_rows, m)
    blocks, pulls = np.empty((m, d, d)), np.empty((m, d))
    cdef double* block = filled(blocks)
    cdef double* pull = filled(pulls)
    cdef double[9] turn, error, weight, whole, part
    cdef double[4] q
    cdef double[3] goal, turned, wanted
    cdef const double* at
    with nogil:
        for e in range(m):
            at = turn_of + a[e] * d * d
            for i in range(d):
                for j in range(d):
                    part[i * d + j] = at[j * d + i]
            product(step, part, whole, d, True)             # Rm' R_a'
            product(whole, turn_of + b[e] * d * d, error, d, False)
            if d == 2:  # in planar models the position error is in the measured frame of b
                for i in range(d):
                    goal[i] = step[i] * shift[0] + step[d + i] * shift[1]
                for i in range(d * d):
                    turn[i] = whole[i]
                turned[0] = atan2(error[2], error[0])
            else:       # twice the vector part of the quaternion is the error of spatial models
                for i in range(d):
                    goal[i] = shift[i]
                for i in range(d * d):
                    turn[i] = part[i]
                quaternion_of(error, q)
                for i in range(d):
                    turned[i] = 2 * q[i + 1]
            for i in range(d):
                wanted[i] = 0
                for j in range(d):
                    weight[i * d + j] = info[i * k + j]
                    wanted[i] += info[i * k + j] * goal[j]
                for j in range(k - d):
                    wanted[i] -= info[i * k + d + j] * turned[j]
            for i in range(d):
                pull[i] = 0
                for j in range(d):
                    pull[i] += turn[j * d + i] * wanted[j]
            product(turn, weight, part, d, True)
            product(part, turn, block, d, False)
            step += d * d
            shift += d
            info += k * k
            block += d * d
            pull += d
    return blocks, pulls


def add_rows(target, rows, values, double sign):
    """Add ``sign * values[k]`` to ``target[rows[k]]`` for all k, repeated rows too; in place."""
    cdef Py_ssize_t m = len(rows), width = target.size // max(len(target), 1), k, i
    cdef const int64_t* row = ints(rows)
    cdef const double* value = reals(values, m * width)
    cdef double* to = filled(target)
    for k in range(m):
        for i in range(width):
            to[row[k] * width + i] += sign * value[k * width + i]


def projected(relaxed):
    """Nearest rotations of planar columns, or of 3 x 3 matrices with positive determinant.

    Of matrices the polar factor, by Newton's iteration with scaling (N. Higham, "Computing the
    polar decomposition - with applications", SIAM J. Sci. Stat. Comput. 7, 1986).

    Parameters
    ----------
    relaxed : (n, 2, 1) or (n, 3, 3)

    Returns
    -------
    rotation : (n, d, d), transposed: body to world
    left : (n,) bool, matrices that are singular or reflections, whose rotation is not computed;
        None: there are none
    """
    cdef Py_ssize_t n = relaxed.shape[0], d = relaxed.shape[1], k, i, j, _
    cdef const double* x = reals(relaxed)
    found, left = np.empty((n, d, d)), np.zeros(n, dtype=np.uint8)
    cdef double* to = filled(found)
    cdef uint8_t* out = <uint8_t*>writable(left, np.uint8)
    cdef double length, det, size, other, scale, change, new
    cdef double[9] y, c
    cdef bint some = False
    for k in range(n):
        if d == 2:
            length = sqrt(x[0] * x[0] + x[1] * x[1])
            to[0] = to[3] = x[0] / length if length > 0 else 1
            to[1] = x[1] / length if length > 0 else 0
            to[2] = -to[1]
            x += 2
            to += 4
            continue
        for i in range(9):
            y[i] = x[i]
        out[k] = True
        for _ in range(ROUNDS):
            size = other = 0
            for i in range(3):
                for j in range(3):
                    c[3 * i + j] = (
                        y[3 * ((i + 1) % 3) + (j + 1) % 3] * y[3 * ((i + 2) % 3) + (j + 2) % 3]
                        - y[3 * ((i + 1) % 3) + (j + 2) % 3] * y[3 * ((i + 2) % 3) + (j + 1) % 3]
                    )
                    size += y[3 * i + j] * y[3 * i + j]
                    other += c[3 * i + j] * c[3 * i + j]
            det = y[0] * c[0] + y[1] * c[1] + y[2] * c[2]
            if not det > FLAT * size * sqrt(size):
                break
            # The inverse transposed is the matrix of cofactors over the determinant.
            scale = sqrt(sqrt(other / size) / det)
            change = 0
            for i in range(9):
                new = 0.5 * (scale * y[i] + c[i] / (det * scale))
                change += (new - y[i]) * (new - y[i])
                y[i] = new
            if change < 1e-30:
                out[k] = False
                break
        some |= out[k]
        for i in range(3):
            for j in range(3):
                to[3 * i + j] = y[3 * j + i]
        x += 9
        to += 9
    return found, left.view(np.bool_) if some else None


def places_of(pattern, block_of, from_rows, to_rows):
    """Offset of the block that each edge couples, -1 where a pose has none or is both ends.

    Parameters
    ----------
    pattern : BlockPattern
    block_of : (n,) int64, block of each pose, or -1
    from_rows, to_rows : (m,) int64

    Raises
    ------
    LookupError
        The pattern lacks a block.
    """
    cdef Py_ssize_t m = len(from_rows), e, lo, hi, middle
    cdef const int64_t* start = ints(pattern.column_start)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef const int64_t* value = ints(pattern.value_start)
    cdef const int64_t* block = ints(block_of)
    cdef const int64_t* a = ints(from_rows)
    cdef const int64_t* b = ints(to_rows, m)
    cdef int64_t i, j
    found = np.full(m, -1, dtype=np.int64)
    cdef int64_t* to = <int64_t*>writable(found, np.int64)
    for e in range(m):
        i, j = min(block[a[e]], block[b[e]]), max(block[a[e]], block[b[e]])
        if i < 0 or i == j:
            continue
        lo, hi = start[i], start[i + 1]
        while lo < hi:
            middle = (lo + hi) // 2
            if rows[middle] < j:
                lo = middle + 1
            else:
                hi = middle
        if lo == start[i + 1] or rows[lo] != j:
            raise LookupError
        to[e] = value[lo]
    return found


def assembled(pattern, block_of, places, from_rows, to_rows, blocks, own, right, held, at):
    """Normal equations of a relaxation; parameters as of `Relaxation.solved`.

    Returns
    -------
    values, diagonal : as a linear solver takes them
    right : (k, n d) right-hand sides
    sound : bool, whether all values are finite and the diagonal is positive
    """
    cdef Py_ssize_t n = right.shape[0], d = right.shape[1], k = right.shape[2], m = len(from_rows)
    cdef Py_ssize_t nb = len(pattern.sizes), e, p, r, c, s, total = nb * d
    cdef const int64_t* start = ints(pattern.column_start)
    cdef const int64_t* value_at = ints(pattern.value_start)
    cdef const int64_t* block = ints(block_of, n)
    cdef const int64_t* place = ints(places, m)
    cdef const int64_t* a = ints(from_rows)
    cdef const int64_t* b = ints(to_rows, m)
    cdef const double* aa = reals(blocks[0], m * d * d)
    cdef const double* ab = reals(blocks[1], m * d * d)
    cdef const double* bb = reals(blocks[2], m * d * d)
    cdef const double* mine = reals(own, n * d * d)
    cdef const double* wanted = reals(right)
    cdef const double* fixed = reals(at, n * d * k)
    cdef const uint8_t* asked = <const uint8_t*>address(held, np.bool_, n)
    # Components that the model or a flag holds leave a pose without a block, too.
    marks = np.empty(n, dtype=np.uint8)
    cdef uint8_t* out = <uint8_t*>writable(marks, np.uint8)
    size = len(pattern.rows) * d * d
    values, diagonal, rhs = np.zeros(size), np.empty(total), np.empty((k, total))
    cdef double* v = filled(values)
    cdef double* diag = filled(diagonal)
    cdef double* g = filled(rhs)
    cdef double* to
    cdef int64_t i, j
    cdef bint sound = True
    cdef Py_ssize_t count = size
    with nogil:
        for p in range(n):
            i = block[p]
            out[p] = asked[p] or i < 0
            if i < 0:
                continue
            to = v + value_at[start[i]]
            for r in range(d):
                for c in range(d):
                    to[r * d + c] = (r == c) if out[p] else mine[(p * d + r) * d + c]
                for s in range(k):
                    g[s * total + i * d + r] = (fixed if out[p] else wanted)[(p * d + r) * k + s]
        for e in range(m):
            i, j = a[e], b[e]
            if i != j:
                if not out[i]:
                    to = v + value_at[start[block[i]]]
                    for r in range(d * d):
                        to[r] += aa[r]
                if not out[j]:
                    to = v + value_at[start[block[j]]]
                    for r in range(d * d):
                        to[r] += bb[r]
                if not (out[i] or out[j]):
                    # A block is stored once, with the later entity as its rows.
                    to = v + place[e]
                    for r in range(d):
                        for c in range(d):
                            if block[i] > block[j]:
                                to[r * d + c] += ab[r * d + c]
                            else:
                                to[c * d + r] += ab[r * d + c]
                # Couplings with fixed poses are moved to the right-hand side.
                elif not out[j]:
                    for r in range(d):
                        for c in range(d):
                            for s in range(k):
                                g[s * total + block[j] * d + c] -= (
                                    ab[r * d + c] * fixed[(i * d + r) * k + s]
                                )
                elif not out[i]:
                    for r in range(d):
                        for c in range(d):
                            for s in range(k):
                                g[s * total + block[i] * d + r] -= (
                                    ab[r * d + c] * fixed[(j * d + c) * k + s]
                                )
            aa += d * d
            ab += d * d
            bb += d * d
        for i in range(nb):
            to = v + value_at[start[i]]
            for r in range(d):
                diag[i * d + r] = to[r * d + r]
                sound &= diag[i * d + r] > 0
        for p in range(count):
            sound &= isfinite(v[p]) != 0
    return values, diagonal, rhs, bool(sound)


def poses_of(solution, block_of, at):
    """Solution by pose, with the values `at` of poses without a block.

    Parameters
    ----------
    solution : (blocks d, k), F order
    block_of : (n,) int64, block of each pose, or -1
    at : (n, d, k)

    Returns
    -------
    found : (n, d, k)
    sound : bool, whether the solution is finite
    """
    cdef Py_ssize_t n = at.shape[0], d = at.shape[1], k = at.shape[2], p, r, s
    cdef Py_ssize_t total = solution.shape[0]
    cdef const double* x = reals(solution.T, total * k)
    cdef const double* fixed = reals(at)
    cdef const int64_t* block = ints(block_of, n)
    found = np.empty((n, d, k))
    cdef double* to = filled(found)
    cdef bint sound = True
    for p in range(total * k):
        sound &= isfinite(x[p]) != 0
    for p in range(n):
        if (block[p] + 1) * d > total:
            raise IndexError(f"block {block[p]} of {total // d}")
        for r in range(d):
            for s in range(k):
                to[0] = fixed[(p * d + r) * k + s]
                if block[p] >= 0:
                    to[0] = x[s * total + block[p] * d + r]
                to += 1
    return found, bool(sound)


def held_of(component, fixed, poses, weight):
    """(n,) bool, poses with a fixed part, and the first of each component that nothing holds.

    Parameters
    ----------
    component : (n,) int64, first pose of each pose's component
    fixed : (n,) bool
    poses, weight : (k,) int64 and f64, poses that are measured absolutely, and how well
    """
    cdef Py_ssize_t n = len(fixed), anchors = len(poses), p
    cdef const int64_t* first = ints(component, n)
    cdef const int64_t* pose = ints(poses)
    cdef const double* weighs = reals(weight, anchors)
    cdef const uint8_t* still = <const uint8_t*>address(fixed, np.bool_)
    found, marks = np.empty(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
    cdef uint8_t* to = <uint8_t*>writable(found, np.bool_)
    cdef uint8_t* holds = <uint8_t*>writable(marks, np.bool_)
    for p in range(n):
        holds[first[p]] |= still[p]
    for p in range(anchors):
        if not 0 <= pose[p] < n:
            raise IndexError(f"pose {pose[p]} of {n}")
        holds[first[pose[p]]] |= weighs[p] > 0
    for p in range(n):
        to[p] = still[p] or (first[p] == p and not holds[p])
    return found

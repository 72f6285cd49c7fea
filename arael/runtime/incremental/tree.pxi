"""A block Cholesky factor that is edited: only what lies above a change is eliminated again.

The factor is multifrontal. A front eliminates a few variables and leaves a Schur complement (its
*update*) over the variables below it to its parent. Every front keeps its update, so that after a
change of the residuals of some variables only the fronts that eliminate these, and the fronts
between them and the root, are taken apart. Their variables are ordered again, those that changed
last, and eliminated again from the residuals that these fronts owned and from the updates of the
subtrees that hang below them, which stay as they are (M. Kaess et al., "iSAM2: Incremental
smoothing and mapping using the Bayes tree", IJRR 31 (2012); here with Schur complements in the
place of marginal factors).

`docs/internals/online.md` has a picture.
"""

import numpy as np

from libc.math cimport fabs, sqrt
from libc.stdint cimport uint8_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy, memset

from arael.runtime.linear.compiled cimport (
    tile_backward, tile_forward, tile_lessen, tile_multiply, tile_potrf, tile_transposed, tile_trsm,
)

from arael.runtime.linear.planning import minimum_degree

cdef enum:
    PAD = 8             # scalars that kernels may touch behind a column

# Rows of a triangle that a column may address: all of them.
cdef Py_ssize_t ALL_ROWS = (<Py_ssize_t>1) << 40

# Pivots below this part of the diagonal of J'J are rounding noise: the residuals do not determine
# the scalar, which then keeps its value.
cdef double NOISE = 1e-12

# A front takes in a child that adds at most this part of zeros to its panel, or twice it while the
# front is small: an assembly costs more than a few products.
cdef double FILL = 0.1
cdef int SMALL_FRONT = 16

# At most this part of the variables to be ordered are put last because they changed.
cdef double LATE = 0.5


cdef class BlockTree:
    """Variables, residual blocks that couple them, and the factor of J'J with its right-hand side.

    Parameters
    ----------
    stride : largest width of a variable
    """

    def __cinit__(self, Py_ssize_t stride):
        self.stride = max(stride, 1)

    def __dealloc__(self):
        cdef Py_ssize_t k
        for k in range(self.front_count):
            self._free_front(<int>k)
        for k in range(self.term_count):
            free(self.terms[k].variable)
            free(self.terms[k].jacobian)
        for k in range(self.variable_count):
            free(self.variables[k].held)
            empty(&self.variables[k].terms)
        free(self.terms)
        free(self.variables)
        free(self.fronts)
        free(self.delta)
        free(self.shown)
        free(self.scale)
        free(self.position)
        free(self.dense)
        free(self.sweep)
        empty(&self.free_terms)
        empty(&self.free_variables)
        empty(&self.free_fronts)
        empty(&self.dropped_terms)
        empty(&self.dropped_variables)
        empty(&self.fresh)
        empty(&self.touched)
        empty(&self.pending)
        empty(&self.recent)
        empty(&self.moved)

    cdef double* workspace(self, Py_ssize_t count) except NULL:
        """Zeros; valid until the next call."""
        if count > self.dense_room:
            self.dense = <double*>grown(self.dense, 0, 2 * count, sizeof(double))
            self.dense_room = 2 * count
        memset(self.dense, 0, count * sizeof(double))
        return self.dense

    # --- variables and terms -----------------------------------------------------------------

    cdef int new_variable(self, int width) except -1:
        """A variable that moves; no residual reads it yet."""
        cdef Py_ssize_t room
        cdef int v
        cdef Variable* one
        if self.free_variables.count:
            self.free_variables.count -= 1
            v = self.free_variables.at[self.free_variables.count]
        else:
            if self.variable_count == self.variable_room:
                room = max(<Py_ssize_t>64, 2 * self.variable_room)
                self.variables = <Variable*>grown(
                    self.variables, self.variable_room, room, sizeof(Variable))
                self.delta = <double*>grown(
                    self.delta, self.variable_room * self.stride, room * self.stride,
                    sizeof(double))
                self.shown = <double*>grown(
                    self.shown, self.variable_room * self.stride, room * self.stride,
                    sizeof(double))
                self.scale = <double*>grown(
                    self.scale, self.variable_room * self.stride, room * self.stride,
                    sizeof(double))
                self.position = <int*>grown(
                    self.position, self.variable_room, room, sizeof(int))
                self.variable_room = room
            v = <int>self.variable_count
            self.variable_count += 1
        one = &self.variables[v]
        one.held = <uint8_t*>grown(one.held, 0, max(width, 1), 1)
        one.alive, one.free, one.width, one.front, one.terms.count = True, True, width, -1, 0
        one.stale = one.dirty = False
        memset(self.delta + v * self.stride, 0, self.stride * sizeof(double))
        memset(self.shown + v * self.stride, 0, self.stride * sizeof(double))
        memset(self.scale + v * self.stride, 0, self.stride * sizeof(double))
        self.live_variables += 1
        push(&self.touched, v)
        return v

    cdef int new_term(self, int count, const int* variable, int rows) except -1:
        """A residual block of some variables, whose Jacobian is to be filled in."""
        cdef Py_ssize_t room
        cdef int t, k, width = 0
        cdef Term* one
        if self.free_terms.count:
            self.free_terms.count -= 1
            t = self.free_terms.at[self.free_terms.count]
        else:
            if self.term_count == self.term_room:
                room = max(<Py_ssize_t>64, 2 * self.term_room)
                self.terms = <Term*>grown(self.terms, self.term_room, room, sizeof(Term))
                self.term_room = room
            t = <int>self.term_count
            self.term_count += 1
        for k in range(count):
            width += self.variables[variable[k]].width
        one = &self.terms[t]
        one.variable = <int*>grown(one.variable, 0, max(count, 1), sizeof(int))
        one.jacobian = <double*>grown(one.jacobian, 0, rows * (width + 1) + 1, sizeof(double))
        memcpy(one.variable, variable, count * sizeof(int))
        one.alive, one.count, one.rows, one.width, one.cost = True, count, rows, width, 0
        one.owner, one.next = UNOWNED, -1
        for k in range(count):
            push(&self.variables[variable[k]].terms, t)
        self.live_terms += 1
        self.live_rows += rows
        self.touch_term(t)
        return t

    cdef int drop_term(self, int t) except -1:
        """Remove a residual block."""
        cdef Term* one = &self.terms[t]
        cdef IntList* there
        cdef int k, i
        self.touch_term(t)
        one.alive = False
        for k in range(one.count):
            there = &self.variables[one.variable[k]].terms
            for i in range(there.count):
                if there.at[i] == t:
                    there.count -= 1
                    there.at[i] = there.at[there.count]
                    break
        self.live_terms -= 1
        self.live_rows -= one.rows
        push(&self.dropped_terms, t)
        return 0

    cdef int drop_variable(self, int v) except -1:
        """Remove a variable, with the residual blocks that still read it."""
        cdef Variable* one = &self.variables[v]
        while one.terms.count:
            self.drop_term(one.terms.at[one.terms.count - 1])
        push(&self.touched, v)
        one.alive = False
        self.live_variables -= 1
        push(&self.dropped_variables, v)
        return 0

    cdef int hold_variable(self, int v, const uint8_t* held) except -1:
        """Let other scalars of a variable move than before."""
        cdef Variable* one = &self.variables[v]
        cdef int k
        memcpy(one.held, held, one.width)
        one.free = False
        for k in range(one.width):
            if not held[k]:
                one.free = True
            else:
                self.delta[v * self.stride + k] = 0
        push(&self.touched, v)
        self.touch_terms(v)
        return 0

    cdef int touch_term(self, int t) except -1:
        """Eliminate all variables of a residual block again."""
        cdef Term* one = &self.terms[t]
        cdef int k
        for k in range(one.count):
            push(&self.touched, one.variable[k])
        if one.owner == UNOWNED:
            one.owner = WAITING
            push(&self.pending, t)
        return 0

    cdef int touch_terms(self, int v) except -1:
        """The same for all residual blocks of a variable."""
        cdef int k
        for k in range(self.variables[v].terms.count):
            self.touch_term(self.variables[v].terms.at[k])
        return 0

    # --- fronts ------------------------------------------------------------------------------

    cdef int _new_front(self) except -1:
        cdef Py_ssize_t room
        if self.free_fronts.count:
            self.free_fronts.count -= 1
            return self.free_fronts.at[self.free_fronts.count]
        if self.front_count == self.front_room:
            room = max(<Py_ssize_t>64, 2 * self.front_room)
            self.fronts = <Front*>grown(self.fronts, self.front_room, room, sizeof(Front))
            self.front_room = room
        self.front_count += 1
        return <int>self.front_count - 1

    cdef void _free_front(self, int f) noexcept:
        free(self.fronts[f].variable)
        free(self.fronts[f].memory)
        self.fronts[f].variable = NULL
        self.fronts[f].memory = NULL
        self.fronts[f].alive = False

    cdef int _make_front(self, const int* variable, int eliminated, int count) except -1:
        """A front over some variables, of which it eliminates the first; nothing is in it yet."""
        cdef int number = self._new_front(), k
        cdef Front* f = &self.fronts[number]
        cdef Py_ssize_t room
        memset(f, 0, sizeof(Front))
        f.alive, f.fresh, f.parent, f.child, f.sibling, f.term = True, True, -1, -1, -1, -1
        f.variable = <int*>grown(NULL, 0, max(count, 1), sizeof(int))
        memcpy(f.variable, variable, count * sizeof(int))
        f.count, f.eliminated = count, eliminated
        for k in range(count):
            if k < eliminated:
                f.columns += self.variables[variable[k]].width
                self.variables[variable[k]].front = number
            else:
                f.below += self.variables[variable[k]].width
        f.tall = (f.columns + PAD - 1) // PAD * PAD
        f.low = (f.below + PAD) // PAD * PAD
        room = (
            <Py_ssize_t>f.tall * f.columns + <Py_ssize_t>f.low * (f.columns + f.below + 1)
            + 2 * f.columns + 2 * f.below + 5 * PAD)
        f.memory = <double*>calloc(room, sizeof(double))
        if f.memory == NULL:
            raise MemoryError
        f.triangle = f.memory
        f.panel = f.triangle + <Py_ssize_t>f.tall * f.columns + PAD
        f.update = f.panel + <Py_ssize_t>f.low * f.columns + PAD
        f.inverse = f.update + <Py_ssize_t>f.low * (f.below + 1) + PAD
        f.mass = f.inverse + f.columns + PAD
        f.seen = f.mass + f.columns + f.below
        push(&self.fresh, number)
        self.refactored += f.columns
        return number

    cdef int _collect(self, IntList* affected, IntList* marked) except -1:
        """Fronts from the touched variables to the roots, and the variables to eliminate again."""
        cdef int k, i, v, f
        cdef Variable* one
        self.stamp += 1
        for k in range(self.touched.count):
            v = self.touched.at[k]
            one = &self.variables[v]
            f = one.front
            while f >= 0 and not self.fronts[f].marked:
                self.fronts[f].marked = True
                push(marked, f)
                f = self.fronts[f].parent
            if one.mark != self.stamp:
                one.mark = self.stamp
                if one.alive and one.free:
                    push(affected, v)
        for k in range(marked.count):
            f = marked.at[k]
            for i in range(self.fronts[f].eliminated):
                v = self.fronts[f].variable[i]
                one = &self.variables[v]
                one.front = -1
                if one.mark != self.stamp:
                    one.mark = self.stamp
                    if one.alive and one.free:
                        push(affected, v)
        for k in range(affected.count):
            self.variables[affected.at[k]].local = k
        return 0

    cdef eliminate(self):
        """Take in all changes since the last call; `descend` then makes the steps current.

        Left unfinished by an exception, it is repeated by the next call.
        """
        cdef IntList affected, marked, orphans, owned, starts, members
        cdef int k, i, f, t, count
        cdef Term* term
        affected.at = marked.at = orphans.at = owned.at = starts.at = members.at = NULL
        affected.count = marked.count = orphans.count = owned.count = starts.count = 0
        affected.room = marked.room = orphans.room = owned.room = starts.room = 0
        members.count = members.room = 0
        self.refactored = 0
        try:
            self._collect(&affected, &marked)
            count = 0
            for k in range(self.fresh.count):  # of an elimination without a `descend`
                f = self.fresh.at[k]
                if self.fronts[f].alive and self.fronts[f].fresh and not self.fronts[f].marked:
                    self.fresh.at[count] = f
                    count += 1
            self.fresh.count = count
            for k in range(marked.count):
                f = self.fronts[marked.at[k]].child
                while f >= 0:
                    if not self.fronts[f].marked:
                        push(&orphans, f)
                    f = self.fronts[f].sibling
                t = self.fronts[marked.at[k]].term
                while t >= 0:
                    if self.terms[t].alive:
                        push(&owned, t)
                    t = self.terms[t].next
            for k in range(self.pending.count):
                if self.terms[self.pending.at[k]].alive:
                    push(&owned, self.pending.at[k])
            self.pending.count = 0

            # What each residual block and each update of a subtree couples.
            for k in range(owned.count):
                push(&starts, members.count)
                term = &self.terms[owned.at[k]]
                for i in range(term.count):
                    if self.variables[term.variable[i]].free:
                        push(&members, self.variables[term.variable[i]].local)
            for k in range(orphans.count):
                push(&starts, members.count)
                f = orphans.at[k]
                for i in range(self.fronts[f].eliminated, self.fronts[f].count):
                    push(&members, self.variables[self.fronts[f].variable[i]].local)
            push(&starts, members.count)

            sequence = self._sequence(&affected, &starts, &members)
            self._build(sequence, &affected, &starts, &members, &owned, &orphans)
            for k in range(marked.count):
                self._free_front(marked.at[k])
                push(&self.free_fronts, marked.at[k])
            for k in range(self.fresh.count):
                if self.fronts[self.fresh.at[k]].alive:
                    self._factorise(self.fresh.at[k])
            self.touched.count = self.recent.count = 0
            for k in range(self.dropped_terms.count):
                push(&self.free_terms, self.dropped_terms.at[k])
            for k in range(self.dropped_variables.count):
                push(&self.free_variables, self.dropped_variables.at[k])
            self.dropped_terms.count = self.dropped_variables.count = 0
        finally:
            empty(&affected)
            empty(&marked)
            empty(&orphans)
            empty(&owned)
            empty(&starts)
            empty(&members)

    cdef _sequence(self, IntList* affected, IntList* starts, IntList* members):
        """Order of elimination of the affected variables: (n,) of their numbers.

        Minimum degree, with those that changed last, since they are the most likely to change in
        the next step.
        """
        cdef int n = affected.count, k, i, j, v, last = 0, to
        cdef int64_t[::1] start, where, weight, fill, clique, neighbour
        cdef int cliques = starts.count - 1
        late = np.zeros(n, dtype=bool)
        cdef uint8_t[::1] is_late = late.view(np.uint8)
        for k in range(self.recent.count):
            v = self.recent.at[k]
            if self.variables[v].alive and self.variables[v].free:
                if not is_late[self.variables[v].local]:
                    is_late[self.variables[v].local] = 1
                    last += 1
        if last > max(2.0, LATE * n):
            late[:] = False
            last = 0
            for k in range(self.recent.count - 1, -1, -1):
                v = self.recent.at[k]
                if self.variables[v].alive and self.variables[v].free:
                    is_late[self.variables[v].local] = 1
                    last = 1
                    break
        order = np.concatenate((np.flatnonzero(~late), np.flatnonzero(late)))
        if n - last < 3:
            return order
        place = np.empty(n, dtype=np.int64)
        place[order] = np.arange(n)
        cdef int64_t[::1] at = place
        # The cliques of each variable, then its neighbours in them.
        start = np.zeros(n + 1, dtype=np.int64)
        for k in range(members.count):
            start[at[members.at[k]] + 1] += 1
        for k in range(n):
            start[k + 1] += start[k]
        clique = np.empty(max(members.count, 1), dtype=np.int64)
        fill = np.array(start)
        for k in range(cliques):
            for i in range(starts.at[k], starts.at[k + 1]):
                v = <int>at[members.at[i]]
                clique[fill[v]] = k
                fill[v] += 1
        seen_array = np.full(n, -1, dtype=np.int64)
        cdef int64_t[::1] seen = seen_array
        where = np.zeros(n + 1, dtype=np.int64)
        found = np.empty(max(8 * n, 64), dtype=np.int64)
        neighbour = found
        to = 0
        for v in range(n):
            seen[v] = v
            for j in range(start[v], start[v + 1]):
                k = <int>clique[j]
                if to + starts.at[k + 1] - starts.at[k] > neighbour.shape[0]:
                    found = np.concatenate((found, np.empty_like(found), np.empty(
                        starts.at[k + 1] - starts.at[k], dtype=np.int64)))
                    neighbour = found
                for i in range(starts.at[k], starts.at[k + 1]):
                    p = at[members.at[i]]
                    if seen[p] != v:
                        seen[p] = v
                        neighbour[to] = p
                        to += 1
            where[v + 1] = to
        weight = np.empty(n, dtype=np.int64)
        for k in range(n):
            weight[at[k]] = self.variables[affected.at[k]].width
        first = minimum_degree(
            np.asarray(where), found[:to], np.asarray(weight), last)
        return np.concatenate((order[first], order[n - last:]))

    cdef _build(
        self, sequence, IntList* affected, IntList* starts, IntList* members, IntList* owned,
        IntList* orphans
    ):
        """Fronts of the affected variables in an order of elimination, with all they own.

        A variable's structure are the later ones that its cliques and its children's structures
        contain; its parent is the first of these.
        """
        cdef int n = affected.count, cliques = starts.count - 1, k, i, c, p, v, first, f, low
        cdef int zeros, entries, size, own
        # By place in the order: variable, parent, first and next child, first clique, merged with,
        # front; scalars eliminated and below, zeros; begin of the structure.
        table = np.full((9, n + 1), -1, dtype=np.int32)
        cdef int32_t[:, ::1] t = table
        cdef int32_t* variable = &t[0, 0]
        cdef int32_t* parent = &t[1, 0]
        cdef int32_t* child = &t[2, 0]
        cdef int32_t* sibling = &t[3, 0]
        cdef int32_t* bucket = &t[4, 0]
        cdef int32_t* top = &t[5, 0]
        cdef int32_t* seen = &t[6, 0]
        cdef int32_t* front = &t[7, 0]
        cdef int32_t* begin = &t[8, 0]
        sums = np.zeros((3, n + 1), dtype=np.int64)
        cdef int64_t[:, ::1] s = sums
        cdef int64_t* width = &s[0, 0]
        cdef int64_t* below = &s[1, 0]
        cdef int64_t* fill = &s[2, 0]
        place = np.empty(n + 1, dtype=np.int32)
        place[np.asarray(sequence, dtype=np.int64)] = np.arange(n, dtype=np.int32)
        cdef int32_t[::1] at = place
        chain = np.full(cliques + 1, -1, dtype=np.int32)
        cdef int32_t[::1] after = chain
        firsts = np.full(cliques + 1, -1, dtype=np.int32)
        cdef int32_t[::1] lowest = firsts
        cdef IntList structure, whole
        memset(&structure, 0, sizeof(IntList))
        memset(&whole, 0, sizeof(IntList))
        for k in range(n):
            variable[at[k]] = affected.at[k]
        for k in range(cliques):
            first = n
            for i in range(starts.at[k], starts.at[k + 1]):
                first = min(first, at[members.at[i]])
            if first < n:
                lowest[k], after[k], bucket[first] = first, bucket[first], k
        try:
            for k in range(n):
                begin[k] = structure.count
                width[k] = self.variables[variable[k]].width
                low = n
                c = bucket[k]
                while c >= 0:
                    for i in range(starts.at[c], starts.at[c + 1]):
                        p = at[members.at[i]]
                        if p > k and seen[p] != k:
                            seen[p] = k
                            push(&structure, p)
                            below[k] += self.variables[variable[p]].width
                            low = min(low, p)
                    c = after[c]
                c = child[k]
                while c >= 0:
                    for i in range(begin[c], begin[c + 1]):
                        p = structure.at[i]
                        if p > k and seen[p] != k:
                            seen[p] = k
                            push(&structure, p)
                            below[k] += self.variables[variable[p]].width
                            low = min(low, p)
                    c = sibling[c]
                begin[k + 1] = structure.count
                if low < n:
                    parent[k], sibling[k], child[low] = low, child[low], k
                # Children whose columns are nearly those of this one join its front.
                c = child[k]
                while c >= 0:
                    zeros = <int>(fill[k] + fill[c] + width[c] * (width[k] + below[k] - below[c]))
                    size = <int>(width[k] + width[c])
                    entries = <int>(size * (size + 1) // 2 + size * below[k])
                    if zeros <= (2 if size <= SMALL_FRONT else 1) * FILL * entries:
                        top[c], fill[k], width[k] = k, zeros, size
                    c = sibling[c]
            # Fronts, children first.
            for k in range(n - 1, -1, -1):
                top[k] = k if top[k] < 0 else top[top[k]]
            for k in range(n):
                child[k] = sibling[k] = -1
            for k in range(n - 1, -1, -1):  # what each front eliminates, in order
                sibling[k], child[top[k]] = child[top[k]], k
            for k in range(n):
                if top[k] != k:
                    continue
                whole.count = 0
                c = child[k]
                while c >= 0:
                    push(&whole, variable[c])
                    c = sibling[c]
                own = whole.count
                for i in range(begin[k], begin[k + 1]):
                    push(&whole, variable[structure.at[i]])
                front[k] = self._make_front(whole.at, own, whole.count)
            for k in range(n):
                if top[k] == k and parent[k] >= 0:
                    self._hang(front[k], front[top[parent[k]]])
            for k in range(owned.count):
                v = owned.at[k]
                self.terms[v].owner = UNOWNED
                if lowest[k] >= 0:
                    f = front[top[lowest[k]]]
                    self.terms[v].owner = OWNED
                    self.terms[v].next, self.fronts[f].term = self.fronts[f].term, v
            for k in range(orphans.count):
                f = -1 if lowest[owned.count + k] < 0 else front[top[lowest[owned.count + k]]]
                self.fronts[orphans.at[k]].parent = -1
                if f >= 0:
                    self._hang(orphans.at[k], f)
        finally:
            empty(&structure)
            empty(&whole)

    cdef void _hang(self, int f, int parent) noexcept:
        self.fronts[f].parent = parent
        self.fronts[f].sibling = self.fronts[parent].child
        self.fronts[parent].child = f

    # --- numbers -----------------------------------------------------------------------------

    cdef int _assemble(self, Front* f) except -1:
        """Sum what a front owns and the updates of its children."""
        cdef int k, i, v, at = 0, c, t
        cdef Variable* one
        memset(f.triangle, 0, <size_t>((<char*>f.inverse) - (<char*>f.triangle)))
        memset(f.mass, 0, (f.columns + f.below) * sizeof(double))
        for k in range(f.count):
            self.position[f.variable[k]] = at
            at += self.variables[f.variable[k]].width
        t = f.term
        while t >= 0:
            self._add_term(f, &self.terms[t])
            t = self.terms[t].next
        c = f.child
        while c >= 0:
            self._extend(f, &self.fronts[c])
            c = self.fronts[c].sibling
        for k in range(f.eliminated):
            v = f.variable[k]
            one = &self.variables[v]
            at = self.position[v]
            for i in range(one.width):
                if one.held[i]:
                    f.triangle[(at + i) * (f.tall + 1)] = f.mass[at + i] = 1
                self.scale[v * self.stride + i] = sqrt(f.mass[at + i])
        return 0

    cdef int _add_term(self, Front* f, Term* t) except -1:
        """Add J'J, -J'r and r'r of a residual block."""
        cdef int wide = t.width + 1, i, j, k, v, row, hi, lo, side = f.columns + f.below
        cdef double* products = self.workspace(<Py_ssize_t>wide * wide + wide)
        cdef int* place = <int*>(products + <Py_ssize_t>wide * wide)
        cdef const double* a
        cdef double x
        cdef double* to
        j = 0
        for k in range(t.count):
            v = t.variable[k]
            for i in range(self.variables[v].width):
                place[j] = -1
                if self.variables[v].free and not self.variables[v].held[i]:
                    place[j] = self.position[v] + i
                j += 1
        place[t.width] = side
        for row in range(t.rows):
            a = t.jacobian + row * wide
            for j in range(wide):
                x = a[j]
                to = products + j * wide
                for i in range(j, wide):
                    to[i] += x * a[i]
        for j in range(wide):
            if place[j] < 0:
                continue
            if j < t.width:
                f.mass[place[j]] += products[j * wide + j]
            for i in range(j, wide):
                if place[i] < 0:
                    continue
                x = products[j * wide + i]
                if i == t.width and j < i:
                    x = -x
                elif place[i] == place[j] and i != j:
                    x = 2 * x  # one variable in two places
                hi, lo = max(place[i], place[j]), min(place[i], place[j])
                if lo >= f.columns:
                    f.update[hi - f.columns + <Py_ssize_t>(lo - f.columns) * f.low] += x
                elif hi >= f.columns:
                    f.panel[hi - f.columns + <Py_ssize_t>lo * f.low] += x
                else:
                    f.triangle[hi + <Py_ssize_t>lo * f.tall] += x
        return 0

    cdef int _extend(self, Front* f, Front* child) except -1:
        """Add the update of a child."""
        cdef int r = child.below + 1, i, j, k, v, at = 0, ti, tj
        cdef int* place = <int*>self.workspace(r)
        cdef const double* u
        cdef double* to
        for k in range(child.eliminated, child.count):
            v = child.variable[k]
            for i in range(self.variables[v].width):
                place[at] = self.position[v] + i
                at += 1
        place[at] = f.columns + f.below
        for i in range(child.below):
            f.mass[place[i]] += child.mass[child.columns + i]
        for j in range(r):
            tj = place[j]
            u = child.update + <Py_ssize_t>j * child.low
            for i in range(j, r):
                ti = place[i]
                if ti >= tj:
                    if tj >= f.columns:
                        f.update[ti - f.columns + <Py_ssize_t>(tj - f.columns) * f.low] += u[i]
                    elif ti >= f.columns:
                        f.panel[ti - f.columns + <Py_ssize_t>tj * f.low] += u[i]
                    else:
                        f.triangle[ti + <Py_ssize_t>tj * f.tall] += u[i]
                elif ti >= f.columns:
                    f.update[tj - f.columns + <Py_ssize_t>(ti - f.columns) * f.low] += u[i]
                elif tj >= f.columns:
                    f.panel[tj - f.columns + <Py_ssize_t>ti * f.low] += u[i]
                else:
                    f.triangle[tj + <Py_ssize_t>ti * f.tall] += u[i]
        return 0

    cdef int _factorise(self, int number) except -1:
        """Eliminate the columns of a front, whose children are done, and form its update."""
        cdef Front* f = &self.fronts[number]
        cdef int k
        cdef bint sound
        self._assemble(f)
        sound = tile_potrf(f.columns, f.columns, ALL_ROWS, f.triangle, f.tall, f.inverse) == 0
        for k in range(f.columns if sound else 0):
            sound = sound and 1 > NOISE * f.mass[k] * f.inverse[k] * f.inverse[k]
        f.undetermined = 0
        if sound:
            tile_trsm(
                f.below + 1, f.columns, f.triangle, f.tall, f.inverse, f.panel, f.low)
        else:
            self._assemble(f)
            self._factorise_carefully(f)
        tile_lessen(0, f.below + 1, f.columns, f.panel, f.low, f.update, f.low)
        return 0

    cdef void _factorise_carefully(self, Front* f) noexcept:
        """Factor a triangle and divide its panel; scalars that nothing determines are held."""
        cdef int i, j, k
        cdef double* a
        cdef double* b
        cdef double pivot
        for j in range(f.columns):
            a = f.triangle + <Py_ssize_t>j * f.tall
            b = f.panel + <Py_ssize_t>j * f.low
            pivot = a[j]
            if not pivot > NOISE * f.mass[j]:
                f.undetermined += 1
                memset(a + j, 0, (f.columns - j) * sizeof(double))
                memset(b, 0, (f.below + 1) * sizeof(double))
                a[j] = f.inverse[j] = 1
                continue
            a[j] = sqrt(pivot)
            f.inverse[j] = 1 / a[j]
            for i in range(j + 1, f.columns):
                a[i] *= f.inverse[j]
            for i in range(f.below + 1):
                b[i] *= f.inverse[j]
            for k in range(j + 1, f.columns):
                for i in range(k, f.columns):
                    f.triangle[i + <Py_ssize_t>k * f.tall] -= a[i] * a[k]
                for i in range(f.below + 1):
                    f.panel[i + <Py_ssize_t>k * f.low] -= b[i] * a[k]

    # --- steps -------------------------------------------------------------------------------

    cdef int descend(self, double tolerance) except -1:
        """Steps of all variables, by fronts from the roots.

        A front that was not eliminated again is passed over, with its subtree, where no scalar
        below it has moved by more than `tolerance` standard deviations (given all others) since
        its steps were computed. Variables that moved by more are listed in `moved`.
        """
        cdef IntList stack
        cdef int k, f, c
        memset(&stack, 0, sizeof(IntList))
        self.stamp += 1
        self.moved.count = 0
        try:
            for k in range(self.fresh.count - 1, -1, -1):
                f = self.fresh.at[k]
                if not (self.fronts[f].alive and self.fronts[f].fresh):
                    continue
                self._solve_front(&self.fronts[f], tolerance)
                self.fronts[f].fresh = False
                c = self.fronts[f].child
                while c >= 0:
                    if not self.fronts[c].fresh and self._has_changed(&self.fronts[c], tolerance):
                        push(&stack, c)
                    c = self.fronts[c].sibling
            self.fresh.count = 0
            while stack.count:
                stack.count -= 1
                f = stack.at[stack.count]
                self._solve_front(&self.fronts[f], tolerance)
                c = self.fronts[f].child
                while c >= 0:
                    if self._has_changed(&self.fronts[c], tolerance):
                        push(&stack, c)
                    c = self.fronts[c].sibling
        finally:
            empty(&stack)
        return 0

    cdef bint _has_changed(self, Front* f, double tolerance) noexcept:
        """Whether the steps below a front have changed since its own were computed."""
        cdef int k, i, v, at = 0
        cdef double change
        for k in range(f.eliminated, f.count):
            v = f.variable[k]
            for i in range(self.variables[v].width):
                change = fabs(self.delta[v * self.stride + i] - f.seen[at])
                if change * self.scale[v * self.stride + i] > tolerance:
                    return True
                at += 1
        return False

    cdef int _solve_front(self, Front* f, double tolerance) except -1:
        """Steps of the variables that a front eliminates, from those below it."""
        cdef int k, i, v, at = 0
        cdef double* y = self.workspace(f.low + f.tall + 2 * PAD)
        cdef double* b = y + f.low + PAD
        cdef Variable* one
        cdef bint moves
        for k in range(f.eliminated, f.count):
            v = f.variable[k]
            for i in range(self.variables[v].width):
                y[at] = f.seen[at] = self.delta[v * self.stride + i]
                at += 1
        for k in range(f.columns):
            b[k] = f.panel[f.below + <Py_ssize_t>k * f.low]
        if f.below:
            tile_transposed(f.below, f.columns, f.panel, f.low, y, b)
        tile_backward(f.columns, f.columns, f.triangle, f.tall, f.inverse, b)
        at = 0
        for k in range(f.eliminated):
            v = f.variable[k]
            one = &self.variables[v]
            moves = False
            for i in range(one.width):
                self.delta[v * self.stride + i] = b[at]
                if fabs(b[at] - self.shown[v * self.stride + i]) * self.scale[
                        v * self.stride + i] > tolerance:
                    moves = True
                at += 1
            if moves and one.mark != self.stamp:
                one.mark = self.stamp
                push(&self.moved, v)
        return 0

    # --- from Python -------------------------------------------------------------------------

    @property
    def undetermined(self):
        """Number of scalars that no residual determines; they keep their values."""
        cdef Py_ssize_t k
        cdef int total = 0
        for k in range(self.front_count):
            if self.fronts[k].alive:
                total += self.fronts[k].undetermined
        return total

    def marginal(self, int v):
        """(width, width) block of the inverse of J'J: covariance of one variable.

        With E its columns of the identity, Y = L^-1 E is zero but on the way from the front of the
        variable to the root, and the block is Y'Y. Rows of held scalars are zero.
        """
        cdef Variable* one = &self.variables[v]
        cdef int wide = one.width, c, i, j, k, u, at, number = one.front
        cdef Py_ssize_t room = self.variable_room * self.stride, long_
        cdef Front* f
        cdef double* x
        cdef double* b
        cdef double* y
        total = np.zeros((wide, wide))
        cdef double[:, ::1] sums = total
        if room * wide > self.sweep_room:  # zeros between calls
            self.sweep = <double*>grown(self.sweep, 0, room * wide, sizeof(double))
            self.sweep_room = room * wide
        for c in range(wide):
            if not one.held[c]:
                self.sweep[c * room + v * self.stride + c] = 1
        while number >= 0:
            f = &self.fronts[number]
            long_ = f.tall + f.low + 4 * PAD
            b = self.workspace(wide * long_)
            for c in range(wide):
                x, y = self.sweep + c * room, b + c * long_ + f.tall + 2 * PAD
                at = 0
                for k in range(f.eliminated):
                    u = f.variable[k]
                    for i in range(self.variables[u].width):
                        b[c * long_ + at] = x[u * self.stride + i]
                        x[u * self.stride + i] = 0
                        at += 1
                tile_forward(
                    f.columns, f.columns, f.triangle, f.tall, f.inverse, b + c * long_)
                if f.below == 0:
                    continue
                tile_multiply(f.below, f.columns, f.panel, f.low, b + c * long_, y)
                at = 0
                for k in range(f.eliminated, f.count):
                    u = f.variable[k]
                    for i in range(self.variables[u].width):
                        x[u * self.stride + i] += y[at]
                        at += 1
            for i in range(wide):
                for j in range(wide):
                    for k in range(f.columns):
                        sums[i, j] += b[i * long_ + k] * b[j * long_ + k]
            number = f.parent
        return total

    def fronts_as_arrays(self):
        """Variables, how many are eliminated, triangle and panel of each front; for tests."""
        cdef Py_ssize_t n, i, j
        cdef Front* f
        found = []
        for n in range(self.front_count):
            f = &self.fronts[n]
            if not f.alive:
                continue
            triangle = np.zeros((f.columns, f.columns))
            panel = np.zeros((f.below + 1, f.columns))
            for j in range(f.columns):
                for i in range(j, f.columns):
                    triangle[i, j] = f.triangle[i + j * f.tall]
                for i in range(f.below + 1):
                    panel[i, j] = f.panel[i + j * f.low]
            variables = [f.variable[i] for i in range(f.count)]
            found.append((variables, f.eliminated, triangle, panel))
        return found

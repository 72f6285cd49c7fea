"""Rows of entities and instances of constraints as variables and residual blocks of a factor.

Every variable has a linearisation point, at which the residual blocks that read it were
differentiated, and an estimate: that point moved by its step. A block whose residuals at the
estimate are not those that the linearisation predicts has its variables linearised anew.
"""

from libc.stdint cimport int32_t

from arael.runtime.address cimport address
from arael.runtime.kernel cimport Lanes, table_of
from arael.runtime.machine.compiled cimport NativeTable, TapeProgram

from arael.runtime.assembly.placement import Placement
from arael.runtime.machine.programs import entity_program, group_program
from arael.runtime.parallel.frames import refresh_frame_of

cdef extern from "stack.h":
    bint stack_suffices(size_t need) noexcept nogil
    bint stack_elsewhere(size_t need, void (*call)(void*) noexcept nogil, void* job) noexcept nogil


# A call that needs another stack.
cdef struct Moving:
    refresh_function refresh
    Py_ssize_t rows
    const void* state
    const void* step
    const int32_t* delta_at
    void* moved


cdef void call_moving(void* job) noexcept nogil:
    cdef Moving* call = <Moving*>job
    call.refresh(call.rows, call.state, call.step, call.delta_at, call.moved)


cdef class Linearisations:
    """What an online solve keeps of a model, in f64.

    Parameters
    ----------
    layout : Layout
    kernels : capsule "arael.kernels" or None
    programs : list of machine.Program, GroupKernel or None, one per group; or None
        As those of `arael.runtime.evaluation.compiled.Groups`.
    natives : NativeTable

    Attributes
    ----------
    tree : the factor
    cost : sum of squared residuals at the estimate
    error : sum of squares by which residuals of stale variables are not those predicted: a bound on
        what another step gains
    relinearised : variables that were linearised anew by the last `iterate`
    evaluated : residual blocks that were evaluated
    """

    def __init__(self, layout, kernels, programs, NativeTable natives):
        cdef EntityRows* entity
        cdef GroupTerms* group
        cdef Py_ssize_t e, g, k
        groups, table = layout.groups, None
        programs = [None] * len(groups) if programs is None else list(programs)
        if kernels is None:
            programs = [
                one or group_program(layout, group_)
                for one, group_ in zip(programs, groups, strict=True)
            ]
        nothing = [
            Placement(np.zeros((0, len(one.uses)), dtype=np.int32), None, None, None)
            for one in groups
        ]
        self.compiled = CompiledGroups(layout, nothing, kernels, programs)
        self.raised = Raised(natives)
        self.tree = BlockTree(max([one.tangent for one in layout.entities], default=1))
        self._keep = [layout, kernels, programs, natives]
        self.priors = {}
        self.entity_count, self.group_count = len(layout.entities), len(groups)
        self.entities = <EntityRows*>grown(
            NULL, 0, self.entity_count + 1, sizeof(EntityRows))
        self.groups = <GroupTerms*>grown(NULL, 0, self.group_count + 1, sizeof(GroupTerms))
        for e, one in enumerate(layout.entities):
            entity = &self.entities[e]
            entity.stored, entity.stride, entity.tangent = one.stored, one.state, one.tangent
            entity.plain = one.plain
            if kernels is not None and e < table_of(kernels).entity_count:
                entity.refresh = table_of(kernels).refresh[e]
                entity.frame = refresh_frame_of(one)
            elif not one.plain:
                program = entity_program(one)
                self._keep.append(program)
                entity.program = <void*>program
        for g, one in enumerate(groups):
            group = &self.groups[g]
            group.residuals, group.uses = one.residuals, len(one.uses)
            group.columns = one.data_count
            group.entries, group.lanes = len(one.jacobian), self.compiled.widths[g]
            group.guarded = one.moving_guard is not None
            group.entity = <int*>grown(NULL, 0, group.uses + 1, sizeof(int))
            group.place = <int*>grown(NULL, 0, group.entries + 1, sizeof(int))
            group.uniform = <double*>grown(NULL, 0, one.uniform_count + 1, sizeof(double))
            starts, width = [], 0
            for k, use in enumerate(one.uses):
                group.entity[k] = use.entity
                starts.append(width)
                width += layout.entities[use.entity].tangent
            for k, (residual, use, tangent) in enumerate(one.jacobian):
                group.place[k] = residual * (width + 1) + starts[use] + tangent

    def __dealloc__(self):
        cdef Py_ssize_t k
        for k in range(self.entity_count):
            free(self.entities[k].linear)
            free(self.entities[k].estimate)
            empty(&self.entities[k].unused)
        for k in range(self.group_count + 1):
            free(self.groups[k].entity)
            free(self.groups[k].place)
            free(self.groups[k].data)
            free(self.groups[k].term)
            free(self.groups[k].uniform)
            empty(&self.groups[k].unused)
            empty(&self.groups[k].batch)
        free(self.entities)
        free(self.groups)
        for k in range(6):
            free(self.buffers[k])
        empty(&self.stale)
        empty(&self.dirty)
        empty(&self.unevaluated)

    cdef void* buffer(self, int number, Py_ssize_t size) except NULL:
        """Memory for `size` scalars."""
        if size > self.rooms[number]:
            self.buffers[number] = grown(self.buffers[number], 0, 2 * size, sizeof(double))
            self.rooms[number] = 2 * size
        return self.buffers[number]

    cdef int _mark(self, IntList* list, bint stale, int v) except -1:
        """Put a variable into a list of those that are stale, or dirty."""
        cdef Variable* one = &self.tree.variables[v]
        if stale and not one.stale:
            one.stale = True
            push(list, v)
        elif not stale and not one.dirty:
            one.dirty = True
            push(list, v)
        return 0

    # --- edits -------------------------------------------------------------------------------

    def add_rows(self, int e, stored):
        """Rows (n, stored) of an entity; returns (n,) the numbers of their variables."""
        cdef EntityRows* one = &self.entities[e]
        values = np.ascontiguousarray(stored, dtype=np.float64)
        numbers = np.empty(len(values), dtype=np.int32)
        cdef int32_t[::1] to = numbers
        cdef Py_ssize_t k, room
        cdef int v
        for k in range(to.shape[0]):
            v = self.tree.new_variable(one.tangent)
            to[k] = v
            self.tree.variables[v].entity = e
            if one.unused.count:
                one.unused.count -= 1
                self.tree.variables[v].slot = one.unused.at[one.unused.count]
                continue
            if one.count == one.room:
                room = max(<Py_ssize_t>64, 2 * one.room)
                one.linear = <double*>grown(
                    one.linear, one.room * one.stride, room * one.stride, sizeof(double))
                one.estimate = <double*>grown(
                    one.estimate, one.room * one.stride, room * one.stride, sizeof(double))
                one.room = room
            self.tree.variables[v].slot = <int>one.count
            one.count += 1
        self._put(e, numbers, values, True)
        return numbers

    def put_rows(self, int e, int32_t[::1] variables, stored):
        """Other values (n, stored) for some rows of an entity: new linearisation points."""
        cdef Py_ssize_t k
        self._put(e, variables, np.ascontiguousarray(stored, dtype=np.float64), True)
        for k in range(variables.shape[0]):
            self._mark(&self.stale, True, variables[k])

    def put_estimates(self, int e, int32_t[::1] variables, stored):
        """Other estimates (n, stored), until those of before are put back."""
        self._put(e, variables, np.ascontiguousarray(stored, dtype=np.float64), False)

    def _put(self, int e, int32_t[::1] variables, double[:, ::1] stored, bint linear):
        cdef EntityRows* one = &self.entities[e]
        cdef Py_ssize_t n = variables.shape[0], k, slot
        if n == 0:
            return
        cdef double* state = <double*>self.buffer(0, n * one.stride)
        cdef double* step = <double*>self.buffer(1, n * one.tangent)
        cdef double* moved = <double*>self.buffer(2, n * one.stride)
        memset(state, 0, n * one.stride * sizeof(double))
        memset(step, 0, n * one.tangent * sizeof(double))
        for k in range(n):
            memcpy(state + k * one.stride, &stored[k, 0], one.stored * sizeof(double))
        self._refresh(e, n, state, NULL, moved)
        for k in range(n):
            # Values that nothing moves stay as they are to the last bit.
            memcpy(moved + k * one.stride, &stored[k, 0], one.stored * sizeof(double))
            slot = self.tree.variables[variables[k]].slot
            if linear:
                memcpy(one.linear + slot * one.stride, moved + k * one.stride,
                       one.stride * sizeof(double))
            memcpy(one.estimate + slot * one.stride, moved + k * one.stride,
                   one.stride * sizeof(double))

    def hold(self, int32_t[::1] variables, uint8_t[:, ::1] held):
        """Let other scalars (n, tangent) of some rows be held, at their present values."""
        cdef Py_ssize_t k
        for k in range(variables.shape[0]):
            self._mark(&self.stale, True, variables[k])
            self.tree.hold_variable(variables[k], &held[k, 0])

    def remove_rows(self, int32_t[::1] variables):
        """Remove rows, whose terms were removed."""
        cdef Py_ssize_t k
        cdef Variable* one
        for k in range(variables.shape[0]):
            one = &self.tree.variables[variables[k]]
            push(&self.entities[one.entity].unused, one.slot)
            self.tree.drop_variable(variables[k])

    def add_terms(self, int g, int32_t[:, ::1] variables, double[:, ::1] data):
        """Instances of a group: variables (n, uses), data (n, columns); returns their numbers."""
        cdef GroupTerms* one = &self.groups[g]
        cdef Py_ssize_t k, n = variables.shape[0], room
        cdef int slot, t, u
        numbers = np.empty(n, dtype=np.int32)
        cdef int32_t[::1] to = numbers
        cdef int none = 0
        for k in range(n):
            if one.unused.count:
                one.unused.count -= 1
                slot = one.unused.at[one.unused.count]
            else:
                if one.count == one.room:
                    room = max(<Py_ssize_t>64, 2 * one.room)
                    one.data = <double*>grown(
                        one.data, one.room * one.columns, room * one.columns + 1, sizeof(double))
                    one.term = <int*>grown(one.term, one.room, room, sizeof(int))
                    one.room = room
                slot = <int>one.count
                one.count += 1
            t = self.tree.new_term(
                one.uses, <const int*>&variables[k, 0] if one.uses else &none, one.residuals)
            self.tree.terms[t].group, self.tree.terms[t].slot = g, slot
            one.term[slot] = to[k] = t
            if one.columns:
                memcpy(one.data + slot * one.columns, &data[k, 0], one.columns * sizeof(double))
            push(&self.unevaluated, t)
            for u in range(one.uses):
                push(&self.tree.recent, variables[k, u])
        return numbers

    def remove_terms(self, int32_t[::1] numbers):
        """Remove instances."""
        cdef Py_ssize_t k
        cdef Term* one
        for k in range(numbers.shape[0]):
            one = &self.tree.terms[numbers[k]]
            self.cost -= one.cost
            push(&self.groups[one.group].unused, one.slot)
            self.tree.drop_term(numbers[k])

    def add_prior(self, int32_t[::1] variables, int rows, evaluate):
        """A residual block that Python evaluates; returns its number.

        Parameters
        ----------
        variables : (n,) that it reads, each once
        rows : residuals
        evaluate : states of the variables, (stored,) each -> (rows, width + 1) Jacobian and
            residuals
        """
        cdef int t = self.tree.new_term(<int>variables.shape[0], <const int*>&variables[0], rows)
        self.tree.terms[t].group, self.tree.terms[t].slot = <int>self.group_count, -1
        self.priors[t] = evaluate
        push(&self.unevaluated, t)
        return t

    def remove_prior(self, int number):
        """Remove such a block."""
        del self.priors[number]
        self.cost -= self.tree.terms[number].cost
        self.tree.drop_term(number)

    def put_data(self, int g, int32_t[::1] numbers, double[:, ::1] data):
        """Other data (n, columns) for some instances of a group."""
        cdef GroupTerms* one = &self.groups[g]
        cdef Py_ssize_t k
        for k in range(numbers.shape[0]):
            if one.columns:
                memcpy(one.data + self.tree.terms[numbers[k]].slot * one.columns, &data[k, 0],
                       one.columns * sizeof(double))
            self.tree.touch_term(numbers[k])
            push(&self.unevaluated, numbers[k])

    def put_uniform(self, int g, double[::1] uniform):
        """Data that all instances of a group share; they are to be given to `put_data` then."""
        if uniform.shape[0]:
            memcpy(self.groups[g].uniform, &uniform[0], uniform.shape[0] * sizeof(double))

    # --- evaluation --------------------------------------------------------------------------

    cdef int _evaluate(
        self, int g, bint at_estimate, double** residuals, double** entries
    ) except -1:
        """Residuals and Jacobian entries of the terms in the batch of a group."""
        cdef GroupTerms* one = &self.groups[g]
        cdef Py_ssize_t n = one.batch.count, wide = one.lanes, blocks = (n + wide - 1) // wide
        cdef Py_ssize_t k, b, w, u, c, m
        cdef Lanes lanes
        cdef const Term* term
        cdef double* data = <double*>self.buffer(0, blocks * wide * one.columns + 1)
        cdef int32_t* row = <int32_t*>self.buffer(1, blocks * wide * one.uses + 1)
        cdef const void** state = <const void**>self.buffer(4, one.uses + 1)
        cdef uint8_t* run = <uint8_t*>self.buffer(5, blocks // 8 + 1)
        memset(run, 0, blocks)
        residuals[0] = <double*>self.buffer(2, n * one.residuals + 1)
        entries[0] = <double*>self.buffer(3, n * one.entries + 1)
        for k in range(blocks * wide):
            term = &self.tree.terms[one.batch.at[min(k, n - 1)]]
            b, w = k // wide, k % wide
            for c in range(one.columns):
                data[(b * one.columns + c) * wide + w] = one.data[term.slot * one.columns + c]
            for u in range(one.uses):
                row[(b * one.uses + u) * wide + w] = self.tree.variables[term.variable[u]].slot
        for u in range(one.uses):
            state[u] = self.entities[one.entity[u]].estimate if at_estimate else (
                self.entities[one.entity[u]].linear)
        memset(&lanes, 0, sizeof(Lanes))
        lanes.n, lanes.data, lanes.uniform, lanes.row = n, data, one.uniform, row
        lanes.state, lanes.natives, lanes.run = state, self.raised.natives.items, run
        with nogil:
            if one.guarded:
                self.compiled.guard(g, &lanes)
            self.compiled.rows(g, &lanes, residuals[0], entries[0])
            self.raised.checked(0)
        if self.compiled.exhausted:
            self.compiled.exhausted = False
            raise MemoryError("no memory for the registers of a program or the stack of a kernel")
        self.raised.again()
        self.evaluated += n
        return 0

    cdef double[:, ::1] _prior(self, int t, bint at_estimate):
        """(rows, width + 1) Jacobian and residuals of a block that Python evaluates."""
        cdef Term* term = &self.tree.terms[t]
        cdef Variable* variable
        cdef EntityRows* rows
        cdef double[::1] to
        cdef int u
        states = []
        for u in range(term.count):
            variable = &self.tree.variables[term.variable[u]]
            rows = &self.entities[variable.entity]
            state = np.empty(rows.stored)
            to = state
            memcpy(
                &to[0],
                (rows.estimate if at_estimate else rows.linear) + variable.slot * rows.stride,
                rows.stored * sizeof(double))
            states.append(state)
        return self.priors[t](states)

    def at_estimates(self, int g, int32_t[::1] numbers):
        """(n, residuals, width + 1) Jacobian and residuals of some instances at the estimates."""
        cdef GroupTerms* one = &self.groups[g]
        cdef Py_ssize_t n = numbers.shape[0], k, i, r
        cdef int wide = self.tree.terms[numbers[0]].width + 1 if n else 1
        cdef double* residuals
        cdef double* entries
        found = np.zeros((n, one.residuals, wide))
        cdef double[:, :, ::1] to = found
        if n == 0:
            return found
        one.batch.count = 0
        for k in range(n):
            push(&one.batch, numbers[k])
        self._evaluate(g, True, &residuals, &entries)
        for k in range(n):
            for i in range(one.entries):
                (&to[k, 0, 0])[one.place[i]] += entries[k * one.entries + i]
            for r in range(one.residuals):
                to[k, r, wide - 1] = residuals[k * one.residuals + r]
        return found

    cdef int _linearise(self) except -1:
        """Jacobians of all terms that wait for one, at the linearisation points."""
        cdef Py_ssize_t k, i, r, c
        cdef int g
        cdef Term* term
        cdef GroupTerms* one
        cdef double* residuals
        cdef double* entries
        cdef double[:, ::1] prior
        cdef double total
        self.tree.stamp += 1
        for g in range(self.group_count + 1):
            self.groups[g].batch.count = 0
        for k in range(self.unevaluated.count):
            term = &self.tree.terms[self.unevaluated.at[k]]
            if term.alive and term.mark != self.tree.stamp:
                term.mark = self.tree.stamp
                push(&self.groups[term.group].batch, self.unevaluated.at[k])
        self.unevaluated.count = 0
        for g in range(self.group_count):
            one = &self.groups[g]
            if one.batch.count == 0:
                continue
            self._evaluate(g, False, &residuals, &entries)
            for k in range(one.batch.count):
                term = &self.tree.terms[one.batch.at[k]]
                memset(term.jacobian, 0, one.residuals * (term.width + 1) * sizeof(double))
                for i in range(one.entries):
                    term.jacobian[one.place[i]] += entries[k * one.entries + i]
                total = 0
                for r in range(one.residuals):
                    total += residuals[k * one.residuals + r] * residuals[k * one.residuals + r]
                    term.jacobian[r * (term.width + 1) + term.width] = residuals[
                        k * one.residuals + r]
                self.cost += total - term.cost
                term.cost = total
        one = &self.groups[self.group_count]
        for k in range(one.batch.count):
            prior = self._prior(one.batch.at[k], False)
            term = &self.tree.terms[one.batch.at[k]]
            memcpy(term.jacobian, &prior[0, 0], term.rows * (term.width + 1) * sizeof(double))
            total = 0
            for r in range(term.rows):
                total += prior[r, term.width] * prior[r, term.width]
            self.cost += total - term.cost
            term.cost = total
        return 0

    cdef int _refresh(
        self, int e, Py_ssize_t n, const double* state, const double* step, double* moved
    ) except -1:
        """States of n rows of an entity, moved by steps (n, tangent); without steps if NULL."""
        cdef EntityRows* one = &self.entities[e]
        cdef Py_ssize_t k, i
        cdef int32_t* at = <int32_t*>self.buffer(4, n + 1)
        cdef Moving job
        cdef bint done = True
        cdef double still = 0
        for k in range(n):
            at[k] = -1 if step == NULL else <int32_t>(k * one.tangent)
        if step == NULL:
            step = <const double*>self.buffers[1]
        if one.program != NULL:
            done = (<TapeProgram>one.program).refresh(
                False, one.stored, n, state, step, at, moved)
        elif one.plain:
            for k in range(n):
                for i in range(one.stride):
                    moved[k * one.stride + i] = state[k * one.stride + i]
                    if at[k] >= 0:
                        moved[k * one.stride + i] += step[at[k] + i]
        elif stack_suffices(one.frame):
            one.refresh(n, state, step, at, moved)
        else:
            job.refresh, job.rows, job.state, job.step = one.refresh, n, state, step
            job.delta_at, job.moved = at, moved
            with nogil:
                done = stack_elsewhere(one.frame, call_moving, &job)
        if not done:
            raise MemoryError("no memory for the step of a row")
        return 0

    cdef int _move(self) except -1:
        """Estimates of the variables that the last `descend` moved."""
        cdef int e, v
        cdef Py_ssize_t k, n
        cdef EntityRows* one
        cdef BlockTree tree = self.tree
        cdef Py_ssize_t stride = tree.stride
        cdef double* state
        cdef double* step
        cdef double* moved
        for e in range(self.entity_count):
            one = &self.entities[e]
            state = <double*>self.buffer(0, tree.moved.count * one.stride + 1)
            step = <double*>self.buffer(1, tree.moved.count * one.tangent + 1)
            moved = <double*>self.buffer(2, tree.moved.count * one.stride + 1)
            n = 0
            for k in range(tree.moved.count):
                v = tree.moved.at[k]
                if tree.variables[v].entity != e:
                    continue
                memcpy(state + n * one.stride, one.linear + tree.variables[v].slot * one.stride,
                       one.stride * sizeof(double))
                memcpy(step + n * one.tangent, tree.delta + v * stride,
                       one.tangent * sizeof(double))
                n += 1
            if n == 0:
                continue
            self._refresh(e, n, state, step, moved)
            n = 0
            for k in range(tree.moved.count):
                v = tree.moved.at[k]
                if tree.variables[v].entity != e:
                    continue
                memcpy(one.estimate + tree.variables[v].slot * one.stride, moved + n * one.stride,
                       one.stride * sizeof(double))
                memcpy(tree.shown + v * stride, tree.delta + v * stride, stride * sizeof(double))
                self._mark(&self.dirty, False, v)
                n += 1
        return 0

    cdef int _check(self, double tolerance) except -1:
        """Costs of the terms of variables that moved; variables of curved terms become stale."""
        cdef BlockTree tree = self.tree
        cdef int g
        cdef Py_ssize_t k, i
        cdef Term* term
        cdef GroupTerms* one
        cdef IntList* there
        cdef double* residuals
        cdef double* entries
        cdef double[:, ::1] prior
        self.error = 0
        tree.stamp += 1
        for g in range(self.group_count + 1):
            self.groups[g].batch.count = 0
        for k in range(tree.moved.count):
            there = &tree.variables[tree.moved.at[k]].terms
            for i in range(there.count):
                term = &tree.terms[there.at[i]]
                if term.mark != tree.stamp:
                    term.mark = tree.stamp
                    push(&self.groups[term.group].batch, there.at[i])
        for g in range(self.group_count):
            one = &self.groups[g]
            if one.batch.count == 0:
                continue
            self._evaluate(g, True, &residuals, &entries)
            for k in range(one.batch.count):
                self._compare(
                    &tree.terms[one.batch.at[k]], residuals + k * one.residuals, 1, tolerance)
        one = &self.groups[self.group_count]
        for k in range(one.batch.count):
            prior = self._prior(one.batch.at[k], True)
            term = &tree.terms[one.batch.at[k]]
            self._compare(term, &prior[0, term.width], prior.shape[1], tolerance)
        return 0

    cdef int _compare(
        self, Term* term, const double* residuals, Py_ssize_t stride, double tolerance
    ) except -1:
        """Cost of a term at the estimate; its variables become stale if it is curved."""
        cdef BlockTree tree = self.tree
        cdef double total = 0, square = 0, off = 0, x
        cdef const double* row
        cdef int r, c, u, v, i
        for r in range(term.rows):
            x = residuals[r * stride]
            total += x * x
            row = term.jacobian + r * (term.width + 1)
            x -= row[term.width]
            c = 0
            for u in range(term.count):
                v = term.variable[u]
                for i in range(tree.variables[v].width):
                    x -= row[c] * tree.shown[v * tree.stride + i]
                    c += 1
            square += x * x
            if not fabs(x) <= off:
                off = fabs(x)
        self.cost += total - term.cost
        term.cost = total
        if not off <= tolerance:
            self.error += square
            for u in range(term.count):
                if self._has_step(term.variable[u]):
                    self._mark(&self.stale, True, term.variable[u])
        return 0

    # --- steps -------------------------------------------------------------------------------

    def relinearise_all(self):
        """Linearise every variable with a step anew at its estimate in the next `iterate`."""
        cdef Py_ssize_t v
        for v in range(self.tree.variable_count):
            if self.tree.variables[v].alive and self._has_step(<int>v):
                self._mark(&self.stale, True, <int>v)

    def prepare(self):
        """Linearise what is new, and what is stale at its estimate; then `cost` is current."""
        cdef Py_ssize_t k, i
        cdef int v
        cdef BlockTree tree = self.tree
        cdef Variable* one
        cdef EntityRows* rows
        self.relinearised = 0
        for k in range(self.stale.count):
            v = self.stale.at[k]
            one = &tree.variables[v]
            one.stale = False
            if not one.alive:
                continue
            self.relinearised += 1
            rows = &self.entities[one.entity]
            memcpy(rows.linear + one.slot * rows.stride, rows.estimate + one.slot * rows.stride,
                   rows.stride * sizeof(double))
            memset(tree.delta + v * tree.stride, 0, tree.stride * sizeof(double))
            memset(tree.shown + v * tree.stride, 0, tree.stride * sizeof(double))
            push(&tree.touched, v)
            tree.touch_terms(v)
            for i in range(one.terms.count):
                push(&self.unevaluated, one.terms.at[i])
        self.stale.count = 0
        # Terms that read variables with steps: their cost is that of their estimates.
        tree.moved.count = 0
        for k in range(self.unevaluated.count):
            if tree.terms[self.unevaluated.at[k]].alive:
                self._note_moved(self.unevaluated.at[k])
        self._linearise()
        if tree.moved.count:
            self._check(float("inf"))

    cdef int _note_moved(self, int t) except -1:
        """List the variables of a term that have a step in `moved`."""
        cdef BlockTree tree = self.tree
        cdef int u
        for u in range(tree.terms[t].count):
            if self._has_step(tree.terms[t].variable[u]):
                push(&tree.moved, tree.terms[t].variable[u])
        return 0

    cdef bint _has_step(self, int v) noexcept:
        """Whether the estimate of a variable is not its linearisation point."""
        cdef Py_ssize_t i
        for i in range(self.tree.variables[v].width):
            if self.tree.shown[v * self.tree.stride + i] != 0:
                return True
        return False

    def step(self, double tolerance, double precision):
        """A Gauss-Newton step from the linearisation points; returns how many are stale after it.

        Parameters
        ----------
        tolerance : residuals that are off by more than this have their variables linearised anew
        precision : steps change that are off by more than this, in standard deviations
        """
        self.tree.eliminate()
        self.tree.descend(precision)
        self._move()
        self._check(tolerance)
        return self.stale.count

    def data_of(self, int g, int32_t[::1] numbers):
        """(n, columns) data of some instances of a group."""
        cdef GroupTerms* one = &self.groups[g]
        cdef Py_ssize_t k
        found = np.empty((numbers.shape[0], one.columns))
        cdef double[:, ::1] to = found
        for k in range(numbers.shape[0] if one.columns else 0):
            memcpy(&to[k, 0], one.data + self.tree.terms[numbers[k]].slot * one.columns,
                   one.columns * sizeof(double))
        return found

    def factorise(self):
        """Factor at the linearisation points, without a step."""
        self.tree.eliminate()

    def take_moved(self):
        """(n,) variables that have moved since the last call."""
        cdef Py_ssize_t k, n = 0
        found = np.empty(self.dirty.count, dtype=np.int32)
        cdef int32_t[::1] to = found
        for k in range(self.dirty.count):
            if self.tree.variables[self.dirty.at[k]].alive:
                to[n] = self.dirty.at[k]
                n += 1
            self.tree.variables[self.dirty.at[k]].dirty = False
        self.dirty.count = 0
        return found[:n]

    def entities_of(self, int32_t[::1] variables):
        """(n,) number of the entity of each variable."""
        found = np.empty(variables.shape[0], dtype=np.int32)
        cdef int32_t[::1] to = found
        cdef Py_ssize_t k
        for k in range(variables.shape[0]):
            to[k] = self.tree.variables[variables[k]].entity
        return found

    def estimates(self, int e, int32_t[::1] variables):
        """(n, stored) estimates of variables of one entity."""
        cdef EntityRows* one = &self.entities[e]
        found = np.empty((variables.shape[0], one.stored))
        cdef double[:, ::1] to = found
        cdef Py_ssize_t k
        for k in range(variables.shape[0]):
            memcpy(&to[k, 0],
                   one.estimate + self.tree.variables[variables[k]].slot * one.stride,
                   one.stored * sizeof(double))
        return found

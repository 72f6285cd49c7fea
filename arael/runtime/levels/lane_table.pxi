"""Instances of one constraint in lane order, in arrays that grow and are edited in place."""

from math import prod

import numpy as np

from arael.runtime.address cimport address
from arael.runtime.kernel cimport KERNEL_ABI, KernelTable, table_of
from arael.runtime.levels.growth cimport grown
from arael.runtime.machine.compiled cimport Program, TapeProgram
from libc.math cimport NAN
from libc.stdint cimport int32_t, uint8_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy, memset

from arael.runtime.machine.compiled import WIDTH
from arael.runtime.machine.programs import group_program


cdef class LaneTable:
    """The instances of one struct, evaluated by its kernel.

    Active instances come first, so that one that is switched off costs nothing; lanes behind the
    last instance repeat it.

    Parameters
    ----------
    layout : Layout
    number : int
        Which group of it.
    kernels : capsule "arael.kernels" or None
        None: the expression machine evaluates it.

    Raises
    ------
    ValueError
        The constraint reads something other than its own data and, through refs, entities of plain
        parameters; or acts only where a guard holds; or the kernels are of another model.
    """

    def __init__(self, layout, Py_ssize_t number, kernels):
        cdef const KernelTable* table
        cdef Py_ssize_t k
        group = layout.groups[number]
        self.struct = group.struct
        columns = [c for c in layout.table(group.table).columns if not c.skip]
        require_plain(layout, group)
        refs = [c.path for c in columns if c.role == "ref"]
        entity_at = {refs.index(group.slots[use.slot].steps[0].ref): layout.entities[use.entity]
                     for use in group.uses}
        self.refs = tuple(refs)
        self.widths = tuple(
            entity_at[k].tangent if k in entity_at else 1 for k in range(len(refs)))
        data = [c for c in columns if c.role == "data"]
        places = [(c.path, k) for c in data for k in range(prod(c.shape))]
        self.fields = tuple(
            path if not next(c for c in data if c.path == path).shape else f"{path}[{k}]"
            for path, k in places)
        defaults = [
            value for c in data for value in (c.default or (np.nan,) * prod(c.shape))]
        uses = [refs.index(group.slots[use.slot].steps[0].ref) for use in group.uses]
        self.arrays.ref_count, self.arrays.field_count = len(refs), len(places)
        self._uses = len(uses)
        self._data, self.arrays.residuals = group.data_count, group.residuals
        self.arrays.entries = len(group.jacobian)
        # Entries by residual, as the kernel writes them.
        residual_of = [residual for residual, _, _ in group.jacobian]
        if residual_of != sorted(residual_of):
            raise ValueError(f"the Jacobian of `{self.struct}` is not in the order of its rows")
        inputs = [places.index((raw.column, raw.component)) for raw in group.raw]
        identity = all(group.prepare.ops[k] == "input" for k in group.prepare.outputs)
        arrays = [
            np.ascontiguousarray(a, dtype=np.int32)
            for a in (
                np.searchsorted(residual_of, range(self.arrays.residuals + 1)),
                [uses[use] for _, use, _ in group.jacobian],
                [tangent for _, _, tangent in group.jacobian],
                uses,
                inputs,
                [inputs[group.prepare.args[k][0]] for k in group.prepare.outputs]
                if identity else [],
                [self.widths[k] for k in uses],
            )
        ]
        self.arrays.begin = <const int32_t*>address(arrays[0], np.int32)
        self.arrays.ref_of = <const int32_t*>address(arrays[1], np.int32)
        self.arrays.tangent = <const int32_t*>address(arrays[2], np.int32)
        self._ref_of_use = <const int32_t*>address(arrays[3], np.int32)
        self._field_of_input = <const int32_t*>address(arrays[4], np.int32)
        self._width_of_use = <const int32_t*>address(arrays[6], np.int32)
        self._inputs = len(inputs)
        prepare = None
        if identity:
            self._field_of_data = <const int32_t*>address(arrays[5], np.int32)
        else:
            prepare = TapeProgram(group.prepare, len(inputs))
            self._prepare = <void*>prepare
            self._registers = (<TapeProgram>prepare).registers()
            if self._registers == NULL:
                raise MemoryError
        self._scratch = <double*>checked(calloc(self._inputs + self._data + 1, sizeof(double)))
        self._defaults = <double*>checked(calloc(self.arrays.field_count + 1, sizeof(double)))
        for k in range(self.arrays.field_count):
            self._defaults[k] = defaults[k]
        self._state = <const void**>checked(calloc(self._uses + 1, sizeof(void*)))
        program = None
        if kernels is None:
            program = group_program(layout, group)
            self._program, self._width = <void*>program, WIDTH
        else:
            table = table_of(kernels)
            if (table.abi != KERNEL_ABI or table.single or
                    table.group_count != len(layout.groups)):
                raise ValueError(f"`{group.label}` has kernels of another model")
            self._kernel, self._width = &table.groups[number], table.lanes
        self._keep = arrays, prepare, program, kernels
        self._lanes.state = self._state
        self.reserve(self._width)

    def __dealloc__(self):
        free(self._registers)
        free(self._scratch)
        free(self._defaults)
        free(self._state)
        free(self.arrays.first)
        free(self.arrays.ref)
        free(self.arrays.field)
        free(self.arrays.at)
        free(self.arrays.residual)
        free(self.arrays.entry)
        free(self._lane_data)
        free(self._lane_row)
        free(self._run)

    @property
    def residuals(self):
        """Rows of an instance."""
        return self.arrays.residuals

    @property
    def count(self):
        """Instances."""
        return self.arrays.count

    @property
    def active(self):
        """Instances that are evaluated."""
        return self.arrays.active

    @property
    def defaults(self):
        """Values of the fields where the data leaves them out; NaN: they must be given."""
        return np.array([self._defaults[k] for k in range(self.arrays.field_count)])

    cdef reserve(self, Py_ssize_t count):
        """Have memory for so many instances."""
        cdef Py_ssize_t capacity = self._width
        cdef LaneArrays* own = &self.arrays
        if count <= self._capacity:
            return
        while capacity < count:
            capacity *= 2
        own.first = <int32_t*>grown(own.first, capacity, sizeof(int32_t))
        own.ref = <int32_t*>grown(own.ref, capacity * own.ref_count, sizeof(int32_t))
        own.field = <double*>grown(own.field, capacity * own.field_count, sizeof(double))
        own.at = <int32_t*>grown(own.at, capacity * own.entries, sizeof(int32_t))
        own.residual = <double*>grown(own.residual, capacity * own.residuals, sizeof(double))
        own.entry = <double*>grown(own.entry, capacity * own.entries, sizeof(double))
        self._lane_data = <double*>grown(self._lane_data, capacity * self._data, sizeof(double))
        self._lane_row = <int32_t*>grown(self._lane_row, capacity * self._uses, sizeof(int32_t))
        self._run = <uint8_t*>grown(self._run, capacity // self._width, 1)
        memset(self._run, 0, capacity // self._width)
        self._capacity = capacity
        self._lanes.data, self._lanes.row = self._lane_data, self._lane_row
        self._lanes.run = self._run

    cdef Py_ssize_t append(
        self, Py_ssize_t first, const int32_t* refs, const double* fields
    ) noexcept nogil:
        """Number of a new instance, which is not active; there is memory for it."""
        cdef LaneArrays* own = &self.arrays
        cdef Py_ssize_t i = own.count
        own.count += 1
        own.first[i] = <int32_t>first
        memcpy(own.ref + i * own.ref_count, refs, own.ref_count * sizeof(int32_t))
        memcpy(own.field + i * own.field_count, fields, own.field_count * sizeof(double))
        self.place(i)
        return i

    cdef void swap(self, Py_ssize_t i, Py_ssize_t j) noexcept nogil:
        """Exchange two instances."""
        cdef LaneArrays* own = &self.arrays
        cdef Py_ssize_t k
        if i == j:
            return
        own.first[i], own.first[j] = own.first[j], own.first[i]
        exchange_int(own.ref + i * own.ref_count, own.ref + j * own.ref_count, own.ref_count)
        exchange(own.field + i * own.field_count, own.field + j * own.field_count, own.field_count)
        exchange_int(own.at + i * own.entries, own.at + j * own.entries, own.entries)
        for k in range(self._data):
            exchange(self._datum(i, k), self._datum(j, k), 1)
        for k in range(self._uses):
            exchange_int(self._row(i, k), self._row(j, k), 1)
        if max(i, j) == self.arrays.count - 1:
            self._pad()

    cdef void drop_last(self) noexcept nogil:
        """Drop the last instance, which is not active."""
        self.arrays.count -= 1
        self._pad()

    cdef void set_active(self, Py_ssize_t count) noexcept nogil:
        self.arrays.active = count
        self._lanes.n = count

    cdef void place(self, Py_ssize_t i) noexcept nogil:
        cdef Py_ssize_t k
        cdef const double* field = self.arrays.field + i * self.arrays.field_count
        cdef double* out = self._scratch + self._inputs
        if self._prepare == NULL:
            for k in range(self._data):
                self._datum(i, k)[0] = field[self._field_of_data[k]]
        else:
            for k in range(self._inputs):
                self._scratch[k] = field[self._field_of_input[k]]
            (<TapeProgram>self._prepare).at(self._registers, self._scratch, out)
            for k in range(self._data):
                self._datum(i, k)[0] = out[k]
        for k in range(self._uses):
            self._row(i, k)[0] = self.arrays.ref[i * self.arrays.ref_count + self._ref_of_use[k]]
        if i == self.arrays.count - 1:
            self._pad()

    cdef void evaluate(self, UnknownWindows unknowns) noexcept nogil:
        cdef Py_ssize_t k
        if not self.arrays.active:
            return
        for k in range(self._uses):
            self._state[k] = unknowns.of_width(self._width_of_use[k])
        self._rows(&self._lanes, self.arrays.residual, self.arrays.entry)

    cdef void evaluate_around(self, UnknownWindows unknowns, Py_ssize_t i) noexcept nogil:
        cdef Py_ssize_t k, block = i // self._width, first = block * self._width
        cdef Lanes lanes = self._lanes
        for k in range(self._uses):
            self._state[k] = unknowns.of_width(self._width_of_use[k])
        lanes.n = min(<Py_ssize_t>self._width, self.arrays.active - first)
        lanes.data = self._lane_data + first * self._data
        lanes.row = self._lane_row + first * self._uses
        lanes.run = self._run + block
        self._rows(
            &lanes, self.arrays.residual + first * self.arrays.residuals,
            self.arrays.entry + first * self.arrays.entries)

    cdef void _rows(self, const Lanes* lanes, double* residual, double* entry) noexcept nogil:
        cdef Py_ssize_t k
        cdef bint exhausted = False
        if self._kernel != NULL:
            self._kernel.rows(lanes, residual, entry)
            return
        (<Program>self._program).rows(lanes, residual, entry, &exhausted)
        if exhausted:
            for k in range(lanes.n * self.arrays.residuals):
                residual[k] = NAN

    cdef inline double* _datum(self, Py_ssize_t i, Py_ssize_t k) noexcept nogil:
        return self._lane_data + (i // self._width * self._data + k) * self._width + i % self._width

    cdef inline int32_t* _row(self, Py_ssize_t i, Py_ssize_t k) noexcept nogil:
        return self._lane_row + (i // self._width * self._uses + k) * self._width + i % self._width

    cdef void _pad(self) noexcept nogil:
        """Let the lanes behind the last instance repeat it."""
        cdef Py_ssize_t last = self.arrays.count - 1, i = self.arrays.count, k
        if not self.arrays.count:
            return
        while i % self._width:
            for k in range(self._data):
                self._datum(i, k)[0] = self._datum(last, k)[0]
            for k in range(self._uses):
                self._row(i, k)[0] = self._row(last, k)[0]
            i += 1


cdef void exchange(double* a, double* b, Py_ssize_t count) noexcept nogil:
    cdef Py_ssize_t k
    for k in range(count):
        a[k], b[k] = b[k], a[k]


cdef void exchange_int(int32_t* a, int32_t* b, Py_ssize_t count) noexcept nogil:
    cdef Py_ssize_t k
    for k in range(count):
        a[k], b[k] = b[k], a[k]


cdef void* checked(void* memory) except NULL:
    if memory == NULL:
        raise MemoryError
    return memory


def require_plain(layout, group):
    """Raise ValueError unless a group reads only what a `LaneTable` holds."""
    label = group.label
    if layout.precision != "f64":
        raise ValueError(f"`{label}` is evaluated in f32, but rows of equations need f64")
    if group.guard is not None or group.moving_guard is not None:
        raise ValueError(f"`{label}` has a guard; switch its instances on and off instead")
    if group.look_ups:
        raise ValueError(f"`{label}` looks rows up; let its data have the values")
    if group.uniform_count or group.calls_natives or group.prefix:
        raise ValueError(f"`{label}` reads data of the root, calls native functions or is nested")
    for slot in group.slots:
        if [step.kind for step in slot.steps] not in ([], ["ref"]):
            raise ValueError(f"`{label}` reads more than its own data and refs")
    for use in group.uses:
        entity = layout.entities[use.entity]
        if not group.slots[use.slot].steps or not entity.plain:
            raise ValueError(f"`{label}` reads {entity.struct}, not a ref to plain parameters")
    for raw in group.raw:
        if group.slots[raw.slot].steps:
            raise ValueError(f"`{label}` reads the data `{raw.column}` through a ref")

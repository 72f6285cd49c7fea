# Cost, gradient and blocks of a problem at its states, by kernels or by the interpreter.

from cython cimport floating
from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.kernel cimport Kernel, KernelTable, Lanes
from arael.runtime.natives cimport NativeTable
from arael.runtime.pool cimport Task


# What the threads of one evaluation work on.
cdef struct Work:
    void* evaluation
    void* gradient
    void* values
    double* totals                        # [shares]
    int which                             # state buffer


cdef class Evaluation:
    cdef readonly bint single             # f32 if true, else f64
    cdef readonly Py_ssize_t size         # scalars of the system
    cdef readonly Py_ssize_t value_count  # scalars of its blocks
    cdef readonly Py_ssize_t trash        # scalars behind the gradient, squared behind the values
    cdef readonly Py_ssize_t shares       # parts that threads accumulate side by side
    cdef public int threads               # that share them
    cdef readonly list states             # [2][entities] arrays (rows, state)
    cdef readonly int current             # which of the two holds the accepted state
    cdef readonly object failure          # exception raised by the interpreter, else None
    cdef bint failed                      # whether there is one, readable without the GIL
    cdef readonly NativeTable natives     # native functions of the model
    cdef readonly object interpreters     # one GroupInterpreter per group, made when asked for

    cdef readonly bint guarded            # whether a guard reads parameters
    cdef list _lane_data                  # per group, its data in lane order, and its uniforms

    cdef object _keep                     # whatever the pointers below point into
    cdef object _still                    # zeros: the step of who does not move
    cdef object _entities, _groups
    cdef object _bounds                   # of the shares, per group, in blocks of lanes
    cdef list _programs                   # per group, machine.Program, GroupKernel or None
    cdef Py_ssize_t _group_count, _entity_count
    cdef const KernelTable* _table        # kernels of the model, or NULL
    cdef Lanes* _lanes[2]                 # [groups], by state buffer
    cdef Lanes* _parts[2]                 # [groups][shares], the same by shares
    cdef uint8_t* _free                   # [groups] whether threads may run it
    cdef Py_ssize_t _gradient_room        # scalars of the gradient with all that lies behind it
    cdef Py_ssize_t _value_room
    cdef const int64_t* _gradient_sums    # (m, 3), see `Shares`
    cdef const int64_t* _value_sums
    cdef const int64_t* _gradient_ends    # [shares + 1] rows of the sums that one thread takes
    cdef const int64_t* _value_ends
    cdef const void** _pointers           # state pointers that the lanes refer to
    cdef void** _state[2]                 # [entities]
    cdef const int32_t** _delta_at        # [entities] first scalar of each row's step, or -1
    cdef Py_ssize_t* _rows                # [entities]
    cdef Py_ssize_t* _moving              # [entities] rows to refresh: all, or 0 if none moves
    cdef Py_ssize_t* _stored              # [entities] stored scalars of a row
    cdef Py_ssize_t* _stride              # [entities] state scalars of a row
    cdef uint8_t* _plain                  # [entities] whether a step is just added
    cdef void** _program                  # [groups] machine.Program, or NULL
    cdef const Kernel** _kernel           # [groups] NULL: the machine or the interpreter runs it
    cdef Py_ssize_t* _width               # [groups] lanes of its data
    cdef uint8_t* _shared                 # [groups] whether all instances read the same rows
    cdef const int64_t* _held             # scalars of the system that do not move
    cdef Py_ssize_t _held_count
    cdef const int64_t* _held_values      # their rows and columns in the values
    cdef Py_ssize_t _held_value_count
    cdef const int64_t* diagonal_at       # [size] offsets of the diagonal in the values

    # Cost at state buffer `which`; NaN if the interpreter failed.
    cdef double cost(self, int which) noexcept nogil
    # Guards over parameters are asked at the current state; `linearise` does so itself.
    cdef void guard(self) noexcept nogil
    # J'r and the blocks of J'J at the current state; scalars held fixed have an identity row.
    cdef double linearise(self, void* gradient, void* values) noexcept nogil
    # The other buffer becomes the current state moved by `step`.
    cdef void move(self, const void* step) noexcept nogil
    # The other buffer becomes the current one.
    cdef void accept(self) noexcept nogil
    # Stored scalars of the current state of one entity.
    cdef void* state(self, Py_ssize_t entity) noexcept nogil
    # Euclidean norm of the stored scalars of all entities that are solved for.
    cdef double norm(self) noexcept nogil

    cdef _take_table(self, kernels)
    cdef _take_kernels(self)
    cdef _allocate(self, Py_ssize_t uses)
    cdef _kept(self, array, dtype)
    cdef _make_states(self, entities, system, stored, dtype)
    cdef _make_lanes(self, layout, structure, instances)
    cdef _make_parts(self, Py_ssize_t g)
    cdef _take_sums(self, plan)
    cdef _place_data(self, Py_ssize_t g, one)
    cdef double _group_cost(self, Py_ssize_t g, int which) noexcept nogil
    cdef double _group_linearise(self, Py_ssize_t g, void* gradient, void* values) noexcept nogil
    cdef void _run_shares(self, Task task, Work* work) noexcept nogil
    cdef double _part_cost(self, Py_ssize_t g, Py_ssize_t share, int which) noexcept nogil
    cdef double _part_linearise(
        self, Py_ssize_t g, Py_ssize_t share, void* gradient, void* values) noexcept nogil
    cdef void _part_guard(self, Py_ssize_t g, Py_ssize_t share) noexcept nogil
    cdef void _whole_guard(self, Py_ssize_t g) noexcept nogil
    cdef void _sum_shares(self, void* gradient, void* values) noexcept nogil
    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil
    cdef void _refresh(self, Py_ssize_t e, int source, int target, const void* step) noexcept nogil
    cdef _interpret_refresh(self, Py_ssize_t e, int source, int target, const void* step)
    cdef _refresh_still(self, Py_ssize_t e)
    cdef _view(self, void* data, Py_ssize_t length)
    cdef double _fail(self, error) noexcept
    cdef double _checked(self, double cost) noexcept nogil

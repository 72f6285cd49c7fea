"""Native functions of a model: how the ones that the caller bound are called."""

import numpy as np

from libc.math cimport NAN
from libc.stdint cimport uintptr_t
from libc.stdlib cimport calloc, free

from arael.runtime.kernel cimport Native

from arael.runtime.machine.native_binding import (
    ARRAY, ARRAY_USER, DISPATCHED, PYTHON, SCALARS, SCALARS_USER, SINGLE,
)

ctypedef double (*call_function)(const Native*, const double*) noexcept nogil
ctypedef void* context

ctypedef double (*d0)() noexcept nogil
ctypedef double (*d1)(double) noexcept nogil
ctypedef double (*d2)(double, double) noexcept nogil
ctypedef double (*d3)(double, double, double) noexcept nogil
ctypedef double (*d4)(double, double, double, double) noexcept nogil
ctypedef double (*d5)(double, double, double, double, double) noexcept nogil
ctypedef double (*d6)(double, double, double, double, double, double) noexcept nogil

ctypedef double (*u0)(context) noexcept nogil
ctypedef double (*u1)(double, context) noexcept nogil
ctypedef double (*u2)(double, double, context) noexcept nogil
ctypedef double (*u3)(double, double, double, context) noexcept nogil
ctypedef double (*u4)(double, double, double, double, context) noexcept nogil
ctypedef double (*u5)(double, double, double, double, double, context) noexcept nogil
ctypedef double (*u6)(double, double, double, double, double, double, context) noexcept nogil

ctypedef double (*k0)(int) noexcept nogil
ctypedef double (*k1)(double, int) noexcept nogil
ctypedef double (*k2)(double, double, int) noexcept nogil
ctypedef double (*k3)(double, double, double, int) noexcept nogil
ctypedef double (*k4)(double, double, double, double, int) noexcept nogil
ctypedef double (*k5)(double, double, double, double, double, int) noexcept nogil
ctypedef double (*k6)(double, double, double, double, double, double, int) noexcept nogil

ctypedef float (*s0)() noexcept nogil
ctypedef float (*s1)(float) noexcept nogil
ctypedef float (*s2)(float, float) noexcept nogil
ctypedef float (*s3)(float, float, float) noexcept nogil
ctypedef float (*s4)(float, float, float, float) noexcept nogil
ctypedef float (*s5)(float, float, float, float, float) noexcept nogil
ctypedef float (*s6)(float, float, float, float, float, float) noexcept nogil

ctypedef double (*an)(int, const double*) noexcept nogil
ctypedef double (*aun)(int, const double*, context) noexcept nogil


cdef double call_scalars(const Native* native, const double* x) noexcept nogil:
    cdef void* f = native.function
    if native.arity == 1:
        return (<d1>f)(x[0])
    if native.arity == 2:
        return (<d2>f)(x[0], x[1])
    if native.arity == 3:
        return (<d3>f)(x[0], x[1], x[2])
    if native.arity == 4:
        return (<d4>f)(x[0], x[1], x[2], x[3])
    if native.arity == 5:
        return (<d5>f)(x[0], x[1], x[2], x[3], x[4])
    if native.arity == 6:
        return (<d6>f)(x[0], x[1], x[2], x[3], x[4], x[5])
    return (<d0>f)()


cdef double call_scalars_user(const Native* native, const double* x) noexcept nogil:
    cdef void* f = native.function
    cdef void* user = native.user_data
    if native.arity == 1:
        return (<u1>f)(x[0], user)
    if native.arity == 2:
        return (<u2>f)(x[0], x[1], user)
    if native.arity == 3:
        return (<u3>f)(x[0], x[1], x[2], user)
    if native.arity == 4:
        return (<u4>f)(x[0], x[1], x[2], x[3], user)
    if native.arity == 5:
        return (<u5>f)(x[0], x[1], x[2], x[3], x[4], user)
    if native.arity == 6:
        return (<u6>f)(x[0], x[1], x[2], x[3], x[4], x[5], user)
    return (<u0>f)(user)


cdef double call_dispatched(const Native* native, const double* x) noexcept nogil:
    cdef void* f = native.function
    if native.arity == 1:
        return (<k1>f)(x[0], 1)
    if native.arity == 2:
        return (<k2>f)(x[0], x[1], 1)
    if native.arity == 3:
        return (<k3>f)(x[0], x[1], x[2], 1)
    if native.arity == 4:
        return (<k4>f)(x[0], x[1], x[2], x[3], 1)
    if native.arity == 5:
        return (<k5>f)(x[0], x[1], x[2], x[3], x[4], 1)
    if native.arity == 6:
        return (<k6>f)(x[0], x[1], x[2], x[3], x[4], x[5], 1)
    return (<k0>f)(1)


cdef double call_single(const Native* native, const double* x) noexcept nogil:
    cdef void* f = native.function
    cdef float s[6]
    cdef Py_ssize_t k
    for k in range(native.arity):
        s[k] = <float>x[k]
    if native.arity == 1:
        return (<s1>f)(s[0])
    if native.arity == 2:
        return (<s2>f)(s[0], s[1])
    if native.arity == 3:
        return (<s3>f)(s[0], s[1], s[2])
    if native.arity == 4:
        return (<s4>f)(s[0], s[1], s[2], s[3])
    if native.arity == 5:
        return (<s5>f)(s[0], s[1], s[2], s[3], s[4])
    if native.arity == 6:
        return (<s6>f)(s[0], s[1], s[2], s[3], s[4], s[5])
    return (<s0>f)()


cdef double call_array(const Native* native, const double* x) noexcept nogil:
    return (<an>native.function)(<int>native.arity, x)


cdef double call_array_user(const Native* native, const double* x) noexcept nogil:
    return (<aun>native.function)(<int>native.arity, x, native.user_data)


cdef double call_python(const Native* native, const double* x) noexcept nogil:
    with gil:
        return (<NativeTable>native.owner).through_python(native, x)


cdef double call_missing(const Native* native, const double* x) noexcept nogil:
    return NAN


cdef class NativeTable:
    """The native functions of one problem, numbered as the layout numbers them.

    Parameters
    ----------
    functions : the native ones of ``Layout.functions``
    bindings : `arael.runtime.machine.native_binding.Binding` by name; what is missing yields NaN
    """

    def __cinit__(self, functions, bindings):
        self.items = <Native*>calloc(max(len(functions), 1), sizeof(Native))
        if self.items == NULL:
            raise MemoryError

    def __init__(self, functions, bindings):
        cdef Native* native
        self.names = [f.name for f in functions]
        self.bindings = {name: bindings[name] for name in self.names if name in bindings}
        for number, function in enumerate(functions):
            native = &self.items[number]
            native.arity = len(function.params)
            native.owner = <void*>self
            binding = self.bindings.get(function.name)
            native.call = call_missing
            if binding is None:
                continue
            if binding.style == PYTHON:
                native.call = call_python
                native.function = <void*>binding.function
                continue
            native.function = <void*><uintptr_t>binding.address
            native.user_data = <void*><uintptr_t>binding.user_data
            if binding.style == SCALARS:
                native.call = call_scalars
            elif binding.style == SCALARS_USER:
                native.call = call_scalars_user
            elif binding.style == DISPATCHED:
                native.call = call_dispatched
            elif binding.style == SINGLE:
                native.call = call_single
            elif binding.style == ARRAY:
                native.call = call_array
            elif binding.style == ARRAY_USER:
                native.call = call_array_user
            else:
                raise ValueError(f"no style {binding.style} of native functions")

    def __dealloc__(self):
        free(self.items)

    cdef double through_python(self, const Native* native, const double* x) noexcept:
        """Call a Python function; what it raises is kept for `raise_failure`.

        ValueError of Python's mathematics is no exception to this: taken for NaN, it would become
        a rejected step, and a solve that a defect of the function stopped would end as converged.
        """
        if self.failed:
            return NAN
        arguments = tuple([x[k] for k in range(native.arity)])
        try:
            return (<object>native.function)(*arguments)
        except BaseException as error:
            shown = ", ".join([f"{value:.6g}" for value in arguments])
            error.add_note(f"in the function bound to `{self.names[native - self.items]}`, "
                           f"called with ({shown})")
            self.failure = error
            self.failed = True
        return NAN

    def clear(self):
        """Forget what a Python function raised, so that it is called again."""
        self.failure, self.failed = None, False

    def raise_failure(self):
        """Raise what a Python function raised, if anything."""
        if self.failed:
            failure = self.failure
            self.clear()
            raise failure

    def __getitem__(self, name):
        """The function of that name on whole columns: arrays or scalars to an array."""
        number = self.names.index(name)
        return lambda *columns: self._columns(number, columns)

    def _columns(self, Py_ssize_t number, columns):
        cdef Native* native = &self.items[number]
        cdef double[:, ::1] values
        cdef double[::1] found
        cdef double nothing = 0
        cdef Py_ssize_t i, n
        wide = np.broadcast_arrays(*[np.asarray(c, dtype=np.float64) for c in columns])
        shape = wide[0].shape if wide else ()
        values = np.ascontiguousarray(
            np.stack([w.ravel() for w in wide], axis=1) if wide else np.zeros((1, 0))
        )
        n = values.shape[0]
        result = np.empty(n)
        found = result
        with nogil:
            for i in range(n):
                found[i] = native.call(native, &values[i, 0] if native.arity else &nothing)
        self.raise_failure()
        kind = np.result_type(*[np.asarray(c).dtype for c in columns], np.float32)
        return result.reshape(shape).astype(kind if wide else np.float64)

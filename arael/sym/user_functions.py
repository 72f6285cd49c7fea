"""Functions of the user, and bags of them that texts are read with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from arael.check.constants import Constants
from arael.check.items import gather
from arael.check.report import Reporter
from arael.check.typed import BOOL, REAL
from arael.compiler.imports import Imports
from arael.diagnostics.arguments import as_list, as_mapping, fail, require
from arael.diagnostics.records import Findings, Source
from arael.sym.evaluation import Compiled
from arael.sym.functions import UserFunction, number
from arael.sym.reading import Reader, call
from arael.sym.values import Value, composite, symbol, type_of
from arael.syntax import tree
from arael.syntax.files import read_source
from arael.syntax.parser import parse as parse_file

Native = Callable[..., float]


class Function:
    """A function of the user; call it with expressions.

    Form A has a formula, ``f(x) = expr``, which is written out where it is called, unless it
    prescribes its derivatives. Form B is `native`: a Python callable that nothing is known of but
    the derivatives it comes with.

    Attributes
    ----------
    name, parameters : as declared
    node : its declaration, as it was read
    native, is_native : the callable of form B, else None; whether there is one
    bag : where the functions that it calls are looked up, when it is called
    """

    def __init__(self, node: tree.Function, bag: FunctionBag, native: Native | None = None) -> None:
        self.node = node
        self.name = node.name.id
        self.parameters = tuple(p.id for p in node.params)
        self.bag = bag
        self.native = native
        self.is_native = node.body is None

    def __repr__(self) -> str:
        """Show the declaration."""
        return f"<function {self.node.span.text}>"

    @cached_property
    def sympy_class(self) -> Any:
        """The SymPy function of calls that stay calls: those of a function with `derivs`."""
        return type(self.name, (UserFunction,), {"declared": self, "nargs": len(self.parameters)})

    def __call__(self, *args: Any) -> Any:
        """Apply to expressions, vectors or numbers.

        Raises
        ------
        AraelError
            E0303 for a wrong number of arguments; what is wrong in its text.
        """
        return call(self.name, args, self.bag)

    def formula(self, args: Iterable[Any]) -> Any:
        """Value of a form A function for these arguments, written out."""
        assert self.node.body is not None
        return self._read(self.node.body, tuple(args))

    def partials(self, args: Iterable[Any]) -> list[Any]:
        """Derivatives by each argument, as prescribed."""
        assert self.node.derivs is not None
        return [self._read(d, tuple(args)) for d in self.node.derivs]

    def native_value(self, *args: Any) -> Any:
        """Value of a form B function on numbers or arrays."""
        assert self.native is not None
        if all(np.ndim(a) == 0 for a in args):
            return float(self.native(*map(float, args)))
        return np.vectorize(self.native, otypes=[np.float64])(*args)

    def evaluate(self, *args: Any) -> Any:
        """Value on numbers or arrays."""
        if self.is_native:
            return self.native_value(*args)
        return Compiled(self.formula(sp.symbols(self.parameters)), self.parameters)(*args)

    def _read(self, node: tree.Expr, args: tuple[Any, ...]) -> Any:
        names = {**self.bag.constants, **dict(zip(self.parameters, args, strict=True))}
        found = Reader(self.bag, names, self.bag.constants).read(node)
        if type_of(found) != REAL:
            fail("E0652", f"`{self.name}` has derivatives, so it must be a scalar", node.span)
        return found


class FunctionBag(Mapping[str, Function]):
    """Functions by name, for `parse` and each other.

    They may call each other in any order; names are looked up when a function is called. A function
    of the bag shadows a built-in one of the same name, also in the other functions of the bag.

    Attributes
    ----------
    constants : values of names in the formulas of all functions: the constants of a model
    """

    def __init__(self, *definitions: str) -> None:
        self._functions: dict[str, Function] = {}
        self.constants: dict[str, Value] = {}
        for definition in definitions:
            self.define(definition)

    def __getitem__(self, name: str) -> Function:
        return self._functions[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)

    def define(self, text: str) -> Function:
        """Add a function from text: ``f(x, y) = x * y``, or with ``derivs [d1, d2]`` before ``=``.

        Raises
        ------
        AraelError
            For what is wrong in the text; E0651 if it is no definition of one function.
        """
        expected, help_ = "the definition of a function", "write `f(x) = x^2`"
        require(isinstance(text, str), "define", "text", expected, text, help_)
        return self._define(f"fn {text.strip().removeprefix('fn ')}", None)

    def _define(self, text: str, native: Native | None) -> Function:
        """Add the one function of a text, of the form that `native` implies."""
        items = parse_file(Source("definition", text)).items
        one = items[0] if len(items) == 1 else None
        if isinstance(one, tree.Function) and (one.body is None) == (native is not None):
            return self.add(one, native)
        help_ = ("write it like `f(x) = x^2`",)
        fail("E0651", "expected the definition of one function", origin="definition", help=help_)

    def native(
        self, name: str, function: Native, parameters: Iterable[str], derivs: Iterable[str]
    ) -> Function:
        """Add a function whose value a Python callable of floats gives.

        `derivs` are formulas of the parameters for the derivatives by each; they may call any
        function of the bag, this one included.
        """
        symbol(name)  # E0651 if that is no name
        require(callable(function), "native", "function", "a function of floats", function)
        formals = as_list(parameters, str, "native", "parameters", "a list of names")
        slopes = as_list(derivs, str, "native", "derivs", "a list of formulas")
        head = f"extern fn {name}({', '.join(formals)})"
        return self._define(f"{head} derivs [{', '.join(slopes)}]", function)

    def add(self, node: tree.Function, native: Native | None = None) -> Function:
        """Add a function that has been read.

        Raises
        ------
        AraelError
            E0651 if parameters and derivatives do not match, or nothing gives its value.
        """
        name, names = node.name, [p.id for p in node.params]
        for i, parameter in enumerate(node.params):
            if parameter.id in names[:i]:
                fail("E0651", f"parameter `{parameter.id}` is declared twice", parameter.span)
        if node.derivs is not None and len(node.derivs) != len(names):
            found = f"{len(names)} parameters and {len(node.derivs)} derivatives"
            help_ = ("give one derivative per parameter, in their order",)
            fail("E0651", f"`{name.id}` has {found}", name.span, help=help_)
        if node.body is None and not callable(native):
            help_ = (f"pass a callable for it: `natives={{{name.id!r}: f}}`",)
            fail("E0651", f"nothing gives the value of `{name.id}`", name.span, help=help_)
        self._functions[name.id] = Function(node, self, native if node.body is None else None)
        return self._functions[name.id]

    @classmethod
    def from_model(
        cls, model: str | Path, natives: Mapping[str, Native] | None = None
    ) -> FunctionBag:
        """Read the functions of a model file and of what it imports, or of the text of one.

        `model` is a path, or text with a line end or ``=`` in it; `natives` are the callables for
        ``extern fn``, by name.

        Raises
        ------
        AraelError
            As reading the model does; E0651 where an ``extern fn`` has no callable.
        """
        fits = isinstance(model, str | Path)
        require(fits, "from_model", "model", "a path or the text of a model", model)
        natives = as_mapping(natives, str, "from_model", "natives", "a mapping by name")
        is_text = isinstance(model, str) and ("\n" in model or "=" in model)
        source = Source("model", str(model)) if is_text else read_source(str(model))
        return cls.from_source(source, natives, None if is_text else Imports())

    @classmethod
    def from_source(
        cls,
        source: Source,
        natives: Mapping[str, Native] | None = None,
        load: Callable[[tree.Import], tree.File] | None = None,
    ) -> FunctionBag:
        """Take the functions of a text, which sees its constants and what `load` imports."""
        report = Reporter(Findings())
        found = gather(parse_file(source), load, report)
        report.stop()
        bag = cls()
        constants = Constants(found, report)
        for name, item in found.consts.items():
            value = constants.evaluate(item.value)
            if value is not None:
                made = composite(value.type, [number(float(x)) for x in value.values])
                bag.constants[name] = sp.Eq(made, 1) if value.type == BOOL else made
        report.stop()
        for function_ in found.functions.values():
            bag.add(function_, (natives or {}).get(function_.name.id))
        return bag


def function(definition: str) -> Function:
    """Make one function: ``sigmoid = function("sigmoid(x) = 1 / (1 + exp(-x))")``."""
    return FunctionBag().define(definition)

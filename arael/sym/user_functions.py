"""Functions of the user, and bags of them that texts are read with."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from arael.check.typed import BOOL, REAL
from arael.diagnostics.records import AraelError, Diagnostic, Findings, Source
from arael.sym.building import build
from arael.sym.errors import fail
from arael.sym.expr import Expr, const
from arael.sym.shapes import as_value, composite
from arael.sym.value import Value
from arael.syntax import tree
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
    native : the callable of form B, else None
    bag : where the functions that it calls are looked up, when it is called
    """

    def __init__(self, node: tree.Function, bag: FunctionBag, native: Native | None = None) -> None:
        self.node = node
        self.name = node.name.id
        self.parameters = tuple(p.id for p in node.params)
        self.bag = bag
        self.native = native

    @property
    def is_native(self) -> bool:
        """Whether the value comes from a Python callable."""
        return self.node.body is None

    def __repr__(self) -> str:
        """Show the declaration."""
        return f"<function {self.node.span.text}>"

    def __call__(self, *args: Any) -> Any:
        """Apply to expressions, vectors or numbers.

        Raises
        ------
        AraelError
            E0303 for a wrong number of arguments; what is wrong in its text.
        """
        from arael.sym.reading import Reader

        return Reader(self.bag, {}).apply(self, [(as_value(a), None) for a in args], None)

    def formula(self, args: Iterable[Expr]) -> Expr:
        """Value of a form A function for these arguments, written out."""
        assert self.node.body is not None
        return self._read(self.node.body, tuple(args))

    def partials(self, args: tuple[Expr, ...]) -> list[Expr]:
        """Derivatives by each argument, as prescribed."""
        assert self.node.derivs is not None
        return [self._read(d, args) for d in self.node.derivs]

    def _read(self, node: tree.Expr, args: tuple[Expr, ...]) -> Expr:
        from arael.sym.reading import Reader

        names = {**self.bag.constants, **dict(zip(self.parameters, args, strict=True))}
        found = Reader(self.bag, names).value(node)
        if not isinstance(found, Expr) or found.type != REAL:
            fail("E0652", f"`{self.name}` has derivatives, so it must be a scalar", node.span)
        return found


class FunctionBag(Mapping[str, Function]):
    """Functions by name, for `parse` and each other.

    They may call each other in any order; names are looked up when a function is called. A function
    of the bag shadows a built-in one of the same name, also in the other functions of the bag.

    Attributes
    ----------
    constants : values of names in the formulas of all functions: the constants of a model. For
        `parse` they are as good as any `names`.
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

    def copy(self) -> FunctionBag:
        """Return a bag with the same functions, which look names up where they did."""
        bag = FunctionBag()
        bag._functions = dict(self._functions)
        bag.constants = dict(self.constants)
        return bag

    def define(self, text: str) -> Function:
        """Add a function from text: ``f(x, y) = x * y``, or with ``derivs [d1, d2]`` before ``=``.

        Raises
        ------
        AraelError
            For what is wrong in the text; E0651 if it is no definition of one function.
        """
        stripped = text.strip()
        source = Source("definition", stripped if stripped.startswith("fn ") else f"fn {stripped}")
        items = parse_file(source).items
        if len(items) != 1 or not isinstance(items[0], tree.Function) or items[0].body is None:
            fail(
                "E0651",
                "expected the definition of one function",
                origin="definition",
                help=("write it like `f(x) = x^2`",),
            )
        return self.add(items[0])

    def native(
        self, name: str, function: Native, parameters: Iterable[str], derivs: Iterable[str]
    ) -> Function:
        """Add a function whose value a Python callable gives.

        Parameters
        ----------
        name : in texts
        function : takes floats, gives a float
        parameters : names of its arguments
        derivs : a formula of the parameters for the derivative by each; may call any function of
            the bag, this one included
        """
        head = f"extern fn {name}({', '.join(parameters)})"
        (item,) = parse_file(Source("definition", f"{head} derivs [{', '.join(derivs)}]")).items
        assert isinstance(item, tree.Function)
        return self.add(item, function)

    def add(self, node: tree.Function, native: Native | None = None) -> Function:
        """Add a function that has been read.

        Raises
        ------
        AraelError
            E0651 if parameters and derivatives do not match, or nothing gives its value.
        """
        names = [p.id for p in node.params]
        for i, parameter in enumerate(node.params):
            if parameter.id in names[:i]:
                fail("E0651", f"parameter `{parameter.id}` is declared twice", parameter.span)
        if node.derivs is not None and len(node.derivs) != len(names):
            fail(
                "E0651",
                f"`{node.name.id}` has {len(names)} parameters and {len(node.derivs)} derivatives",
                node.name.span,
                help=("give one derivative per parameter, in their order",),
            )
        if node.body is None and (native is None or not callable(native)):
            fail(
                "E0651",
                f"nothing gives the value of `{node.name.id}`",
                node.name.span,
                help=(f"pass a callable for it: `natives={{{node.name.id!r}: f}}`",),
            )
        function = Function(node, self, native if node.body is None else None)
        self._functions[function.name] = function
        return function

    @classmethod
    def from_model(
        cls, model: str | Path, natives: Mapping[str, Native] | None = None
    ) -> FunctionBag:
        """Read the functions of a model file and of what it imports, or of the text of one.

        Parameters
        ----------
        model : path of an ``.arael`` file, or text with a line end or ``=`` in it
        natives : callables for its ``extern fn``, by name

        Raises
        ------
        AraelError
            As reading the model does; E0651 where an ``extern fn`` has no callable.
        """
        from arael.compiler.imports import Imports
        from arael.syntax.files import read_source

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
        from arael.check.constants import Constants
        from arael.check.items import gather
        from arael.check.report import Reporter

        report = Reporter(Findings())
        found = gather(parse_file(source), load, report)
        report.stop()
        bag = cls()
        constants = Constants(found, report)
        for name, item in found.consts.items():
            value = constants.evaluate(item.value)
            if value is not None:
                entries = tuple(const(float(number)) for number in value.values)
                if value.type == BOOL:
                    bag.constants[name] = build("eq", *entries, const(1.0))
                else:
                    bag.constants[name] = composite(value.type, entries)
        report.stop()
        for function_ in found.functions.values():
            bag.add(function_, (natives or {}).get(function_.name.id))
        return bag


def function(definition: str) -> Function:
    """Make one function: ``sigmoid = function("sigmoid(x) = 1 / (1 + exp(-x))")``."""
    return FunctionBag().define(definition)


def recursion(trail: list[str], name: str, function: Function) -> AraelError:
    """The error for a function in text that calls itself."""
    chain = " -> ".join([*trail[trail.index(name) :][:6], name])
    return AraelError(
        Diagnostic(
            "E0605",
            f"function calls itself: {chain}",
            function.node.name.span,
            "cannot be written out as a formula",
            help=("formulas have no loops; give the function as a closed formula",),
        )
    )

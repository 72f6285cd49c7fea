"""Rule: a field has an existing type that its role allows.

Allowed: ``param`` of the parameter types; plain data of every value type, optional or with a
default; structs by value; collections of structs; refs and lists of them of fixed length; ``skip``
of plain data and refs.

Not allowed: ``param`` of a string or an optional; a list of numbers; ``euler`` without ``param``;
an optional collection; a default for a struct; ``skip`` of a collection or a struct.
"""

from __future__ import annotations

from dataclasses import replace

from arael.check.constants import Constants
from arael.check.declared import Declarations, FieldDecl, StructDecl
from arael.check.defaults import bounds_of, default_of, default_within
from arael.check.limits import MAX_REF_LIST
from arael.check.report import Reporter
from arael.check.suggest import nearest
from arael.check.typed import BOOL, REAL, ValueType, VectorType
from arael.check.types import (
    FIXED_TYPES,
    PARAM_TYPES,
    BadSize,
    shape_of,
    size_of,
    sized,
    type_text,
    value_type,
)
from arael.check.units_fields import declare_unit
from arael.diagnostics.records import Span
from arael.runtime.layout import Param
from arael.syntax import tree

# Names of other languages for types of arael.
_OTHER_TYPES = {"float": "real", "double": "real", "f32": "real", "f64": "real", "str": "string"}


class Fields:
    """Resolves the fields of structs."""

    def __init__(self, declarations: Declarations, constants: Constants, report: Reporter) -> None:
        self.declarations = declarations
        self.constants = constants
        self.report = report

    def declare(self, node: tree.Field) -> FieldDecl | None:
        """One field; None after an error."""
        declared = self._typed(node)
        if declared is None:
            return None
        declare_unit(declared, self.report)
        if declared.kind != "column" and (node.default is not None or node.bounds is not None):
            what = "default" if node.default is not None else "bounds"
            self._wrong(node.span, f"`{declared.text}` takes no {what}", "only plain values do")
            return None
        if node.default is not None:
            default = default_of(declared, node.default, self.constants, self.report)
            if default is None:
                return None
            declared.default = default
        if node.bounds is not None:
            bounded = bounds_of(declared, node.bounds, self.constants, self.report)
            if bounded is None:
                return None
            if node.default is not None and not default_within(
                declared, bounded, node.default, self.report
            ):
                return None
            declared.param = bounded
        return declared

    def _typed(self, node: tree.Field) -> FieldDecl | None:
        type_ = node.type
        text = type_text(type_)
        name = node.name.id
        plain = isinstance(type_, tree.NamedType)
        skipped = node.role == "skip" and isinstance(type_, tree.RefType)
        value = isinstance(type_, tree.NamedType | tree.OptionalType)
        if node.role != "data" and not value and not skipped:
            return self._wrong(
                type_.span,
                f"`{node.role}` takes a value type, found `{text}`",
                "not a value",
                "omit `skip`: data that no constraint reads costs nothing in a solve"
                if node.role == "skip"
                else "omit `param`: the parameters of the rows are found",
            )
        if isinstance(type_, tree.NamedType):
            if node.role == "param":
                return self._param(node, type_, text)
            if type_.name == "constraint_index" and node.role == "data":
                return FieldDecl(name, node, "constraint_index", text)
            return self._named(node, type_, text, optional=False)
        if isinstance(type_, tree.OptionalType):
            if node.role == "param":
                return self._wrong(
                    type_.span,
                    "a parameter cannot be optional",
                    "a parameter always has a value",
                    "put the parameter into a struct and make that optional",
                )
            return self._named(node, type_.inner, text, optional=True)
        if isinstance(type_, tree.CollectionType):
            if not self._held(type_.element, f"`{type_.kind} of` takes a struct"):
                return None
            return FieldDecl(
                name, node, "collection", text, struct=type_.element.name, collection=type_.kind
            )
        if isinstance(type_, tree.RefType):
            target = tree.NamedType(name=type_.target.id, span=type_.target.span)
            if not self._held(target, "a ref points to a struct"):
                return None
            return FieldDecl(
                name, node, "ref", text, struct=type_.target.id, optional=type_.optional
            )
        if isinstance(type_, tree.RefListType):
            return self._ref_list(node, type_, text)
        assert not plain
        return FieldDecl(
            name, node, "block" if isinstance(type_, tree.BlockType) else "triplets", text
        )

    def _ref_list(self, node: tree.Field, type_: tree.RefListType, text: str) -> FieldDecl | None:
        """A list of refs; its elements are refs under ``name.0``, ``name.1``, ..."""
        if type_.count > MAX_REF_LIST:
            return self._wrong(
                type_.span,
                f"a list of {type_.count} refs is too long",
                f"at most {MAX_REF_LIST} are allowed",
                "every pair of its elements has a block of the Hessian; put the rest into rows of "
                "a `list of`, with a residual each",
            )
        name = node.name.id
        elements = []
        for k in range(type_.count):
            ident = tree.Ident(span=node.name.span, id=f"{name}.{k}")
            element = self._typed(replace(node, name=ident, type=type_.ref))
            if element is None:
                return None
            elements.append(element)
        return FieldDecl(
            name, node, "refs", text, struct=type_.ref.target.id, elements=tuple(elements)
        )

    def _named(
        self, node: tree.Field, type_: tree.NamedType, text: str, *, optional: bool
    ) -> FieldDecl | None:
        name, unit = node.name.id, type_.unit.text if type_.unit else ""
        value = value_type(type_)
        if isinstance(value, BadSize):
            return self._size(type_, value)
        if value is not None:
            if value == BOOL and optional:
                return self._wrong(
                    node.type.span,
                    "a bool cannot be optional",
                    "three states",
                    "use an int, or a bool with a default",
                )
            return FieldDecl(
                name, node, "column", text, value, shape_of(value), optional=optional, unit=unit
            )
        if type_.name in PARAM_TYPES:
            reading = PARAM_TYPES[type_.name][0]
            return self._wrong(
                type_.span,
                f"`{type_.name}` is a type of parameters",
                "this field is data",
                f"write `param {name}: {type_.name}`, or `{name}: {reading}` for data",
            )
        if not self._struct(type_, ""):
            return None
        if self.declarations.structs[type_.name].component:
            return self._wrong(
                type_.span,
                f"`{type_.name}` is a component",
                "a component is a parameter",
                f"write `param {name}: {type_.name}`",
            )
        if node.role == "skip":
            return self._wrong(
                type_.span,
                "`skip` takes a value type",
                f"{type_.name} is a struct",
                "omit `skip`: data that no constraint reads costs nothing in a solve",
            )
        return FieldDecl(name, node, "struct", text, struct=type_.name, optional=optional)

    def _param(self, node: tree.Field, type_: tree.NamedType, text: str) -> FieldDecl | None:
        name, unit = node.name.id, type_.unit.text if type_.unit else ""
        reading: ValueType
        if type_.name in PARAM_TYPES and not type_.dims:
            reading, param = PARAM_TYPES[type_.name]
            shape: tuple[int, ...] = () if param.stored == 1 else (param.stored,)
            return FieldDecl(name, node, "column", text, reading, shape, unit=unit, param=param)
        value = value_type(type_)
        if isinstance(value, BadSize):
            return self._size(type_, value)
        if value == REAL or isinstance(value, VectorType):
            n = size_of(value)
            param = Param("real" if value == REAL else "vec", n, n)
            return FieldDecl(
                name, node, "column", text, value, shape_of(value), unit=unit, param=param
            )
        held = self.declarations.structs.get(type_.name)
        if value is None and held is None:
            self._unknown(type_)
            return None
        if held is not None and held.component:
            return FieldDecl(name, node, "struct", text, struct=held.name, component=True)
        help_ = f"a parameter is: real, vec2, vec3, vec<n>, {', '.join(PARAM_TYPES)}"
        if type_.name == "quat":
            help_ = "write `quaternion` for a parameter"
        elif held is not None:
            help_ = f"omit `param`: the parameters within {type_.name} are found"
        return self._wrong(
            type_.span, f"`{type_.name}` cannot be a parameter", "not solvable", help_
        )

    def _struct(self, type_: tree.NamedType, need: str) -> bool:
        name = type_.name
        if name in self.declarations.broken:
            return False
        struct = self.declarations.structs.get(name)
        if struct is None:
            if need and (name in FIXED_TYPES or name in PARAM_TYPES or name in ("vec", "mat")):
                self._wrong(
                    type_.span,
                    f"{need}, found `{name}`",
                    "not a struct",
                    f"wrap it: `struct Item {{ x: {type_text(type_)} }}`",
                )
            else:
                self._unknown(type_)
            return False
        if struct.node.kind == "root":
            self._wrong(type_.span, f"`{name}` is a root", "no field can contain a root")
            return False
        return True

    def _held(self, type_: tree.NamedType, need: str) -> bool:
        if not self._struct(type_, need):
            return False
        if self.declarations.structs[type_.name].component:
            self._wrong(
                type_.span,
                f"{need}, found the component `{type_.name}`",
                "a component is a parameter",
                f"wrap it: `struct Item {{ param x: {type_.name} }}`",
            )
            return False
        return True

    def _unknown(self, type_: tree.NamedType) -> None:
        if type_.name in self.declarations.broken:
            return
        structs = [s.name for s in self.declarations.structs.values() if s.node.kind == "struct"]
        near = (
            sized(type_.name)
            or _OTHER_TYPES.get(type_.name)
            or nearest(type_.name, [*structs, *FIXED_TYPES, *PARAM_TYPES])
        )
        self.report.error(
            "E0203",
            type_.span,
            f"unknown type `{type_.name}`",
            label="not found",
            help=[f"did you mean `{near}`?"]
            if near
            else [f"declare it: `struct {type_.name} {{ ... }}`"],
        )

    def _size(self, type_: tree.NamedType, bad: BadSize) -> FieldDecl | None:
        self.report.error(
            "E0311", type_.span, f"`{type_text(type_)}` {bad.reason}", label="not a type"
        )
        return None

    def _wrong(self, span: Span, message: str, label: str, help_: str = "") -> FieldDecl | None:
        """Report an error; returns None for the caller to return."""
        self.report.error("E0407", span, message, label=label, help=[help_] if help_ else [])
        return None


def declare_fields(fields: Fields, struct: StructDecl) -> None:
    """Resolve all fields of a struct; duplicates and reserved names are found elsewhere."""
    for member in struct.node.members:
        if isinstance(member, tree.Field) and member.name.id not in struct.fields:
            declared = fields.declare(member)
            if declared is not None:
                struct.fields[declared.name] = declared
            else:
                fields.declarations.broken.add(member.name.id)

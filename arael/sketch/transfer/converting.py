"""Another unit of lengths for a sketch whose size stays: every length is converted."""

from __future__ import annotations

from dataclasses import replace

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Dimension, Parameter
from arael.sketch.editing.editor import Editor
from arael.sketch.expressions.dependencies import amounts_of
from arael.sketch.expressions.evaluation import compiled
from arael.sketch.expressions.reading import literal
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.expressions.units import factor
from arael.sketch.transfer.similar import Similarity, mapped

_POWERS = {"length": 1, "area": 2}
_ROUNDING = 1e-9


def converted(editor: Editor, unit: str) -> None:
    """Change the unit of lengths and convert all of them, so that the part keeps its size.

    Plain numbers of expressions for lengths are in the unit so far: `width / 2` becomes
    `(width / 2) * 1 mm`. Parameters keep their numbers.

    Raises
    ------
    AraelError
        E1261: an expression adds plain numbers to lengths, so that it cannot be converted
    """
    document = editor.document
    by = Similarity(factor=factor(document.unit, unit))
    with document.transaction("unit"):
        wanted = _converted_numbers(document, by.factor)
        _spell_units(document)
        document.set_setting("unit", unit)
        names = list(document.entities)
        if names:
            mapped(editor, names, by)
        for one in list(document.dimensions.values()):
            moved = {
                field: getattr(one, field) * by.factor
                for field in ("offset", "along")
                if isinstance(getattr(one, field, None), float)
            }
            if moved:
                document.put("dimensions", replace(one, **moved))
        editor.solve()
        _require(document, wanted)


def _converted_numbers(document: Document, by: float) -> dict[tuple[str, str], float]:
    """What each dimension and parameter has to be in the new unit."""
    scope = DocumentScope(document)
    found: dict[tuple[str, str], float] = {}
    for dimension in document.dimensions.values():
        power = _POWERS.get(DIMENSIONS[dimension.kind].quantity, 0)
        for field, amount in amounts_of(dimension):
            found[dimension.name, field] = amount.number * by**power
    for parameter in document.parameters.values():
        amount = parameter.amount
        power = _POWERS.get(compiled(amount.text).quantity(scope), 0)
        found[parameter.name, "amount"] = amount.number * by**power
    return found


def _spell_units(document: Document) -> None:
    """Write the unit so far to expressions for lengths that give plain numbers."""
    scope = DocumentScope(document)
    for one in list(document.dimensions.values()):
        power = _POWERS.get(DIMENSIONS[one.kind].quantity, 0)
        for field, amount in amounts_of(one):
            if not power or literal(amount.text) is not None:
                continue
            if compiled(amount.text).quantity(scope):
                continue
            text = f"({amount.text})" + f" * 1 {document.unit}" * power
            one = replace(one, **{field: replace(amount, text=text)})  # type: ignore[arg-type]
        document.put("dimensions", one)


def _require(document: Document, wanted: dict[tuple[str, str], float]) -> None:
    records: list[Dimension | Parameter] = [*document.dimensions.values()]
    for record in [*records, *document.parameters.values()]:
        for field, amount in amounts_of(record):
            number = wanted[record.name, field]
            if abs(amount.number - number) > _ROUNDING * max(abs(number), 1e-300):
                raise AraelError(
                    Diagnostic(
                        "E1261",
                        f"`{record.name}` cannot be converted: `{amount.text}` adds plain numbers "
                        "to lengths",
                        help=("write their units first, such as `5 mm`, or use `relabel`",),
                    )
                )

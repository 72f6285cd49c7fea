"""Types, paths and names where they are declared."""

from __future__ import annotations

from typing import Any

from arael.diagnostics.records import Span
from arael.syntax import tree
from arael.syntax.building.base import Builder


class TypeBuilder(Builder):
    """Builds types."""

    def _make_optional_type(self, parts: list[Any], span: Span) -> tree.OptionalType:
        return tree.OptionalType(span=span, inner=parts[0])

    def _make_collection_type(self, parts: list[Any], span: Span) -> tree.CollectionType:
        word, element = parts
        return tree.CollectionType(span=span, kind=word.text, element=element)

    def _make_ref_type(self, parts: list[Any], span: Span) -> tree.RefType:
        target, path, question = parts
        return tree.RefType(span=span, target=target, path=path, optional=question is not None)

    def _make_ref_list_type(self, parts: list[Any], span: Span) -> tree.RefListType:
        target, path, number = parts
        inner = self._log.span(target.span.start, path.span.end)
        ref = tree.RefType(span=inner, target=target, path=path)
        (count,) = self._make_dims([number], span)
        return tree.RefListType(span=span, ref=ref, count=count)

    def _make_block_type(self, parts: list[Any], span: Span) -> tree.BlockType:
        return tree.BlockType(span=span, entities=tuple(parts))

    def _make_ref_element(self, parts: list[Any], span: Span) -> tree.Ident:
        name, number = parts
        if not number.text.isdigit() or len(number.text) > 9:
            self._log.error(
                "E0127",
                f"`{number.text}` is no index",
                number.start,
                number.end,
                "expected a whole number, counted from 0",
            )
            return name  # type: ignore[no-any-return]
        return tree.Ident(span=span, id=f"{name.id}[{int(number.text)}]")

    def _make_triplets_type(self, parts: list[Any], span: Span) -> tree.TripletsType:
        return tree.TripletsType(span=span)

    def _make_named_type(self, parts: list[Any], span: Span) -> tree.NamedType:
        name, dims, unit = parts
        return tree.NamedType(span=span, name=name.text, dims=dims or (), unit=unit)

    def _make_dims(self, parts: list[Any], span: Span) -> tuple[int, ...]:
        dims = []
        for number in parts:
            whole = number.text.isdigit() and len(number.text) <= 9 and int(number.text) > 0
            if not whole:
                self._log.error(
                    "E0127",
                    f"`{number.text}` is not a dimension",
                    number.start,
                    number.end,
                    "expected a whole number of at least 1",
                )
            dims.append(int(number.text) if whole else 1)
        return tuple(dims)

    def _make_unit(self, parts: list[Any], span: Span) -> tree.Unit:
        return tree.Unit(span=span, text="".join(t.text for t in parts[1:-1]))

    def _make_path(self, parts: list[Any], span: Span) -> tree.Path:
        return tree.Path(span=span, parts=tuple(parts))

    def _make_ident(self, parts: list[Any], span: Span) -> tree.Ident:
        return tree.Ident(span=span, id=parts[0].text)

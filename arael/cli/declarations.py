"""What the structs of a model declare beside fields and constraints: ties, priors, what is held."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from arael.diagnostics.records import Source
from arael.syntax import tree
from arael.syntax.parser import parse


@dataclass(frozen=True)
class Declaration:
    """A member of a struct, as the model writes it.

    Attributes
    ----------
    kind : ``derived`` (``param b = 2 * a``), ``prior`` or ``fixed``
    struct : name of the struct
    name : the derived parameter; the parameter of the prior; what is fixed
    text : the formula; the distribution with its clauses; "" of what is fixed
    where : its place, ``slam.arael:31:5``
    """

    kind: str
    struct: str
    name: str
    text: str
    where: str
    doc: str = ""

    def to_dict(self) -> dict[str, str]:
        """Plain data for JSON."""
        text = {"derived": "formula", "prior": "distribution"}.get(self.kind, "")
        found = {"struct": self.struct, "name": self.name, "where": self.where}
        return found | ({text: self.text, "doc": self.doc} if text else {})

    def __str__(self) -> str:
        sign = {"derived": "=", "prior": "~"}.get(self.kind, "")
        return " ".join(part for part in (f"{self.struct}.{self.name}", sign, self.text) if part)


def declarations(sources: Iterable[Source]) -> list[Declaration]:
    """The declarations of all files of a model, in order."""
    return [one for source in sources for one in _of_file(parse(source))]


def _of_file(file: tree.File) -> Iterator[Declaration]:
    for struct in file.items:
        if not isinstance(struct, tree.Struct):
            continue
        for member in struct.members:
            for kind, name, text, doc in _parts(member):
                place = str(member.span)
                yield Declaration(kind, struct.name.id, name, text, place, doc)


def _parts(member: tree.Member) -> Iterator[tuple[str, str, str, str]]:
    """Kind, name, text and documentation."""
    if isinstance(member, tree.Tie):
        yield "derived", member.name.id, _line(member.value), member.doc
    elif isinstance(member, tree.Prior):
        args = ", ".join(_line(arg) for arg in member.args)
        text = f"{member.distribution.id}({args})"
        if member.guard is not None:
            text += f" when {_line(member.guard)}"
        if member.loss is not None:
            text += f" loss {_line(member.loss)}"
        yield "prior", _line(member.target), text, member.doc
    elif isinstance(member, tree.Fixed):
        for path in member.paths:
            yield "fixed", _line(path), "", ""


def _line(node: tree.Node) -> str:
    """The text of a node on one line."""
    return " ".join(node.span.text.split())

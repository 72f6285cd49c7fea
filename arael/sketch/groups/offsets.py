"""Offsets of sequences of curves: what holds them, and their editing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import cast

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.document.document import Document
from arael.sketch.document.measures import signed
from arael.sketch.document.records import Amount, Dimension, Group, Option
from arael.sketch.editing.editor import Editor
from arael.sketch.geometry.blocks import numbers_of
from arael.sketch.geometry.circular import Arc
from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.elliptic import Ellipse, EllipticArc
from arael.sketch.geometry.offsets import (
    Element,
    OffsetError,
    OffsetSide,
    Piece,
    largest,
    offset_side,
)
from arael.sketch.groups.copies import names_of, owned_since
from arael.sketch.groups.sequences import Chain, end_of

_OVAL = (Ellipse, EllipticArc)


@dataclass(frozen=True, slots=True)
class Offset:
    """What an offset was given.

    Attributes
    ----------
    distance, distance2 : on the first side, and on the other one of two sides
    form : ``one`` side, ``symmetric``, or ``two`` sides
    side : +1 if the first side is to the left of the sequence, else -1
    rounded : arcs round the corners that the result goes round
    caps : ``line`` or ``round`` across the ends of both sides, else ``none``
    pinned : whether free ends and tangent joints are held on the normals of the sources
    """

    distance: Amount
    distance2: Amount | None = None
    form: str = "one"
    side: int = 1
    rounded: bool = False
    caps: str = "none"
    pinned: bool = True

    @property
    def sides(self) -> list[tuple[int, Amount]]:
        """Sign and distance of every side."""
        found = [(self.side, self.distance)]
        if self.form != "one":
            found.append((-self.side, self.distance2 or self.distance))
        return found


@dataclass(frozen=True, slots=True)
class Made:
    """What an offset has become.

    Attributes
    ----------
    group : its record
    sides : what is on every side
    added, gone : entities that were added and deleted
    approximate : whether it is the ellipse beside an ellipse, which no offset is
    """

    group: Group
    sides: tuple[OffsetSide, ...]
    added: tuple[str, ...]
    gone: tuple[str, ...]
    approximate: bool


def chain_of(group: Group) -> Chain:
    """The sources of an offset in their order."""
    options = group.options
    return Chain.of(group.sources, str(options["directions"]), bool(options["closed"]))


def results_of(group: Group) -> tuple[list[str], list[str], list[str]]:
    """Entities on the first and on the second side, and the caps."""
    first = int(cast("int", group.options["count"]))
    second = first + int(cast("int", group.options["count2"]))
    names = list(group.results)
    return names[:first], names[first:second], names[second:]


def pins_of(group: Group) -> tuple[str, ...]:
    """Constraints that hold free ends and tangent joints; those that were deleted included."""
    pins = group.options["pins"]
    assert isinstance(pins, tuple)
    return tuple(map(str, pins))


def make(editor: Editor, chain: Chain, given: Offset, quiet: bool, construction: bool) -> Made:
    """A new offset.

    Raises
    ------
    AraelError
        E1273: it does not exist at this distance, or not of these curves
    """
    with editor.document.transaction("offset"):
        return _Build(editor, chain, given, quiet, construction).made("", (), ())


def change(editor: Editor, group: Group, given: Offset) -> Made:
    """Give an offset other options; sides whose curves and joints stay the same are moved."""
    document = editor.document
    with document.transaction(f"offset {group.name}"):
        document.remove("groups", group.name)
        first, second, caps = results_of(group)
        build = _Build(editor, chain_of(group), given, False, False)
        shapes = [group.options["shape"], group.options["shape2"]]
        old = [(first, shapes[0]), (second, shapes[1])]
        same = (
            [one.shape for one in build.sides] == [shape for names, shape in old if names]
            and given.caps == group.options["caps"]
            and given.pinned == group.options["pinned"]
            # half circles run counter-clockwise: on the other side their ends change places
            and (given.caps != "round" or given.side == group.options["side"])
        )
        pins = [name for name in pins_of(group) if name in document.constraints]
        if same:
            return build.moved(group, first, second, caps, pins)
        kept: list[list[str]] = []
        gone = list(caps)
        for k, (names, shape) in enumerate(old):
            if k < len(build.sides) and build.sides[k].shape == shape:
                kept.append(names)
            else:
                kept.append([])
                gone += names
        ends: list[str] = []
        if group.options["caps"] == "round":
            sides = set(kept[0] + kept[1])
            ends = [name for name in group.owned if _holds_cap(document, name, sides)]
        editor.delete([*gone, *pins, *ends])
        owned = tuple(name for name in group.owned if document.find(name) is not None)
        return build.made(group.name, owned, tuple(gone), kept)


def _holds_cap(document: Document, name: str, kept: set[str]) -> bool:
    """Whether an owned constraint is the pin of a cap, which has no entity of the cap."""
    one = document.constraints.get(name)
    return one is not None and one.kind == "on_normal" and one.args[0].partition(".")[0] in kept


class _Build:
    def __init__(
        self, editor: Editor, chain: Chain, given: Offset, quiet: bool, construction: bool
    ) -> None:
        self.editor, self.document = editor, editor.document
        self.chain, self.given = chain, given
        self.quiet, self.construction = quiet, construction
        self.curves = chain.curves(self.document)
        self.oval = isinstance(self.curves[0], _OVAL) and len(self.curves) == 1
        self.sides = tuple(self._planned(sign * one.number) for sign, one in given.sides)
        if given.caps != "none":
            self._require_ends()
        self.pins: list[str] = []

    # --- geometry -----------------------------------------------------------------------------

    def _planned(self, shift: float) -> OffsetSide:
        if self.oval:
            return self._beside_oval(shift)
        for name, curve in zip(self.chain.names, self.curves, strict=True):
            if not isinstance(curve, Piece):
                raise _refused(
                    f"{name} has no offset here: a curve beside "
                    f"{_article(self.document.entities[name].kind)} is none that a sketch has",
                    "only an ellipse or elliptic arc alone has one, which is approximate",
                )
        curves = cast("list[Piece]", self.curves)
        closed, rounded = self.chain.closed, self.given.rounded
        try:
            return offset_side(curves, closed, shift, rounded=rounded)
        except OffsetError as error:
            limit = largest(curves, closed, shift, rounded=rounded)
            raise _refused(
                f"{self.chain.names[error.number]} has no offset of {abs(shift):.6g} to the "
                f"{'left' if shift > 0.0 else 'right'}: {error.reason}",
                f"the distance is to be less than {limit:.6g}"
                if limit > 0.0
                else "there is none at any distance",
            ) from None

    def _beside_oval(self, shift: float) -> OffsetSide:
        oval = self.curves[0]
        assert isinstance(oval, Ellipse | EllipticArc)
        turn = shift if isinstance(oval, Ellipse) or oval.sweep > 0.0 else -shift
        if min(oval.rx, oval.ry) <= turn:
            raise _refused(
                f"{self.chain.names[0]} has no offset of {abs(shift):.6g} inside",
                f"the distance is to be less than {min(oval.rx, oval.ry):.6g}",
            )
        new: Curve
        if isinstance(oval, Ellipse):
            new = Ellipse(oval.center, oval.rx - turn, oval.ry - turn, oval.rotation)
        else:
            new = EllipticArc(
                *(oval.center, oval.rx - turn, oval.ry - turn, oval.rotation),
                *(oval.angle, oval.sweep),
            )
        return OffsetSide((Element(0, cast("Piece", new)),), (), ())

    def _require_ends(self) -> None:
        if self.chain.closed or len(self.sides) < 2:
            what = "a closed sequence has no ends" if self.chain.closed else "one side has no caps"
            raise _refused(f"caps close the ends of two sides: {what}", "write `symmetric`")
        if self.given.caps == "round" and (self.given.form != "symmetric" or self.oval):
            raise _refused("round caps are half circles between equal distances", "`caps line`")

    # --- records ------------------------------------------------------------------------------

    def moved(
        self,
        group: Group,
        first: list[str],
        second: list[str],
        caps: list[str],
        pins: Sequence[str],
    ) -> Made:
        """The same entities at their new places."""
        self.pins = list(pins)
        with self.editor.together():
            for side, names in zip(self.sides, (first, second), strict=False):
                self._place(side, names)
            for name, numbers in zip(caps, self._caps(), strict=True):
                at = self.document.entities[name].at
                self.document.set_values(range(at, at + len(numbers[1])), numbers[1])
            self._value([first, second], group.owned)
        return self._record(group.name, [first, second], caps, group.owned, (), ())

    def made(
        self,
        name: str,
        owned: tuple[str, ...],
        gone: tuple[str, ...],
        kept: Sequence[list[str]] = ((), ()),  # type: ignore[assignment]
    ) -> Made:
        """New entities for the sides that are not there, then caps and pins."""
        before = names_of(self.document)
        entities = set(self.document.entities)
        names: list[list[str]] = [[], []]
        caps: list[str] = []
        with self.editor.together():
            for k, side in enumerate(self.sides):
                names[k] = list(kept[k])
                if names[k]:
                    self._place(side, names[k])
                else:
                    names[k] = [self._entity(one) for one in side.elements]
                    self._hold(side, names[k])
            caps = self._cap(names)
            if self.given.pinned:
                for side, mine in zip(self.sides, names, strict=False):
                    self._pin(side, mine)
            owned += tuple(n for n in owned_since(self.document, before) if n not in self.pins)
            self._value(names, owned)
        added = tuple(one for one in self.document.entities if one not in entities)
        return self._record(name, names, caps, owned, added, gone)

    def _record(
        self,
        name: str,
        names: list[list[str]],
        caps: list[str],
        owned: tuple[str, ...],
        added: tuple[str, ...],
        gone: tuple[str, ...],
    ) -> Made:
        given, sides = self.given, self.sides
        options: Mapping[str, Option] = {
            "distance": given.distance.text,
            "distance2": given.distance2.text if given.distance2 else "",
            "form": given.form,
            "side": given.side,
            "round": given.rounded,
            "caps": given.caps,
            "pinned": given.pinned,
            "closed": self.chain.closed,
            "directions": self.chain.directions,
            "shape": sides[0].shape,
            "shape2": sides[1].shape if len(sides) > 1 else (),
            "count": len(names[0]),
            "count2": len(names[1]),
            "pins": tuple(self.pins),
        }
        name = name or self.document.next_name("M")
        results = (*names[0], *names[1], *caps)
        group = Group(name, "offset", self.chain.names, results, owned, options)
        return Made(self.document.put("groups", group), sides, added, gone, self.oval)

    def _place(self, side: OffsetSide, names: Sequence[str]) -> None:
        for name, element in zip(names, side.elements, strict=True):
            _, numbers = numbers_of(element.curve)
            at = self.document.entities[name].at
            self.document.set_values(range(at, at + len(numbers)), numbers)

    def _entity(self, element: Element) -> str:
        source = self.document.entities[self.chain.names[element.source]]
        kind, numbers = numbers_of(element.curve)
        clockwise = source.clockwise
        if element.corner:
            assert isinstance(element.curve, Arc)
            clockwise = element.curve.sweep < 0.0
        return self.editor.add(
            kind,
            numbers,
            connect=False,
            construction=self.construction or source.construction,
            quiet=self.quiet or source.quiet,
            style=source.style,
            clockwise=clockwise and kind in ("arc", "earc"),
        ).entity.name

    def _end(self, element: Element, name: str, last: bool) -> str:
        """Handle of an end of a result, in the direction of the sequence."""
        backwards = not element.corner and self.chain.links[element.source].backwards
        return end_of(self.document, name, backwards, last)

    def _source_end(self, element: Element, last: bool) -> str:
        link = self.chain.links[element.source]
        return end_of(self.document, link.name, link.backwards, last)

    def _hold(self, side: OffsetSide, names: Sequence[str]) -> None:
        """Hold the results of a side to their sources and to each other.

        The distance passes a tangent joint and an arc round a corner: each run of these has one.
        """
        constrain, elements, joints = self.editor.constrain, side.elements, side.joints
        count = len(elements)
        endless = len(joints) == count > 0 and "sharp" not in joints
        for k, (element, name) in enumerate(zip(elements, names, strict=True)):
            source = self.chain.names[element.source]
            if element.corner:
                # closing a loop of tangent joints, the centre would say one thing twice
                if endless and k == count - 1:
                    before = elements[k - 1]
                    pin = self._end(before, names[k - 1], True), self._source_end(before, True)
                    constrain("on_normal", pin)
                else:
                    center = self._source_end(element, True)
                    constrain("coincident", (f"{name}.center", center))
                continue
            straight = self.document.entities[name].kind == "line"
            constrain("parallel" if straight else "concentric", (source, name))
            if self.oval:
                constrain("parallel", (source, name))
                for kind in ("radius", "radius_b"):
                    self.editor.dimension(kind, (name,))
            elif (k == 0 and (len(joints) < count or endless)) or joints[k - 1] == "sharp":
                self.editor.dimension("distance", (source, name))
        for k, kind in enumerate(joints):
            a, b = k, (k + 1) % count
            ends = self._end(elements[a], names[a], True), self._end(elements[b], names[b], False)
            if not (endless and k == count - 1 and kind == "smooth"):
                constrain("coincident", ends)
            if kind == "round":
                constrain("tangent", ends)

    def _pin(self, side: OffsetSide, names: Sequence[str]) -> None:
        """Hold free ends and tangent joints on the normals of the sources."""
        elements, joints = side.elements, side.joints
        count = len(elements)
        pins: list[tuple[str, str]] = []
        for k, kind in enumerate(joints):
            if kind != "smooth":
                continue
            one = elements[k]
            pins.append((self._end(one, names[k], True), self._source_end(one, True)))
            if k == count - 1 and "sharp" not in joints:
                first = elements[0]
                pins.append((self._end(first, names[0], False), self._source_end(first, False)))
        if len(joints) < count and not self.chain.closed and self.given.caps != "round":
            for k, last in ((0, False), (count - 1, True)):
                one = elements[k]
                pins.append((self._end(one, names[k], last), self._source_end(one, last)))
        self.pins += [self.editor.constrain("on_normal", pin).name for pin in pins]

    def _value(self, names: Sequence[Sequence[str]], owned: Sequence[str]) -> None:
        """Values of the distances: the first has the expression, the others follow it."""
        document, given = self.document, self.given
        leads: dict[str, str] = {}
        for k, (sign, amount) in enumerate(given.sides):
            mine = set(names[k])
            for name in owned:
                one = document.dimensions.get(name)
                if one is None or not mine.intersection(one.args):
                    continue
                if self.oval:
                    self._value_of_oval(one, sign, amount)
                    continue
                key = "first" if given.form == "symmetric" else str(k)
                lead = leads.setdefault(key, name)
                value = amount if lead == name else Amount(lead, amount.number)
                side = -1 if signed(document, "distance", one.args, "") < 0.0 else 1
                document.put("dimensions", replace(one, value=value, side=side))

    def _value_of_oval(self, one: Dimension, sign: int, amount: Amount) -> None:
        oval = self.curves[0]
        inward = sign if isinstance(oval, Ellipse) or oval.sweep > 0.0 else -sign  # type: ignore[attr-defined]
        source = self.chain.names[0]
        size = oval.rx if one.kind == "radius" else oval.ry  # type: ignore[attr-defined]
        text = f"{source}.{one.kind}{'-' if inward > 0 else '+'}({amount.text})"
        value = Amount(text, size - inward * amount.number)
        self.document.put("dimensions", replace(one, value=value))

    # --- caps -----------------------------------------------------------------------------------

    def _caps(self) -> list[tuple[str, list[float]]]:
        """Kind and numbers of the caps, at the beginning and at the end of the sequence."""
        if self.given.caps == "none":
            return []
        one, two = (side.elements for side in self.sides)
        ends = [
            (one[0].curve.start, two[0].curve.start),
            (two[-1].curve.end, one[-1].curve.end),
        ]
        if self.given.caps == "line":
            return [("line", [*a, *b]) for a, b in ends]
        found = []
        for a, b in ends:
            center = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
            first, last = (a, b) if self.given.side > 0 else (b, a)
            found.append(("arc", [*center, *first, *last, self.given.distance.number]))
        return found

    def _cap(self, names: Sequence[Sequence[str]]) -> list[str]:
        found: list[str] = []
        for last, (kind, numbers) in zip((False, True), self._caps(), strict=False):
            sides = zip(self.sides, names, strict=True)
            k = -1 if last else 0
            a, b = (self._end(side.elements[k], mine[k], last) for side, mine in sides)
            made = self.editor.add(
                kind, numbers, connect=False, quiet=self.quiet, construction=self.construction
            ).entity
            found.append(made.name)
            if kind == "line":
                pairs = [(f"{made.name}.{p}", q) for p, q in zip(("p1", "p2"), _turn(a, b, last))]  # noqa: B905
            else:
                flip = last != (self.given.side < 0)
                handles = _turn(a, b, flip)
                pairs = [(f"{made.name}.{p}", q) for p, q in zip(("start", "end"), handles)]  # noqa: B905
            for pair in pairs:
                self.editor.constrain("coincident", pair)
            if kind == "arc":
                for pair in pairs:
                    self.editor.constrain("tangent", pair)
                self.editor.constrain(
                    "on_normal", (a, self._source_end(self.sides[0].elements[k], last))
                )
        return found


def _turn(a: str, b: str, swap: bool) -> tuple[str, str]:
    return (b, a) if swap else (a, b)


def _article(kind: str) -> str:
    names = {"bezier": "a spline", "bspline": "a spline", "earc": "an elliptic arc"}
    return names.get(kind, "an ellipse")


def _refused(message: str, hint: str) -> AraelError:
    return AraelError(Diagnostic("E1273", message, help=(hint,)))

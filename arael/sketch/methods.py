"""Commands as methods; made from their table by `arael.sketch.commands.python`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from arael.sketch.things import Point, Thing

Argument: TypeAlias = Thing | Point | str | float | Sequence[float]
"""A word of a command: a thing or its name, a number, an expression, a pair of coordinates."""


class Commands:
    """Every command as a method."""

    def _command(
        self, word: str, arguments: Sequence[Argument | None], flags: Mapping[str, bool]
    ) -> Any:
        raise NotImplementedError

    def add_point(
        self,
        at: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A point.

        As a command::

            add_point x,y [noconnect] [nocursor] [quiet] [constr]
        """
        return self._command(
            "add_point",
            (at,),
            {"noconnect": noconnect, "nocursor": nocursor, "quiet": quiet, "constr": constr},
        )

    def add_line(
        self,
        *points: Argument,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
    ) -> Any:
        """A line between two points, or a chain of lines through any number of them.

        As a command::

            add_line x1,y1 x2,y2 [noconnect] [notangent] [nocursor] [driven] [quiet] [constr]
            add_line x1,y1 x2,y2 x3,y3 ...
            add_line x2,y2
        """
        return self._command(
            "add_line",
            (*points,),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
            },
        )

    def add_rect(
        self,
        first: Argument,
        second: Argument,
        *,
        noconnect: bool = False,
        noconstraint: bool = False,
        hv: bool = False,
        driven: bool = False,
        strict: bool = False,
        quiet: bool = False,
        constr: bool = False,
        nocursor: bool = False,
    ) -> Any:
        """A rectangle from two opposite corners: four lines.

        As a command::

            add_rect x1,y1 x2,y2 [hv] [driven] [strict] [noconnect] [noconstraint]
        """
        return self._command(
            "add_rect",
            (first, second),
            {
                "noconnect": noconnect,
                "noconstraint": noconstraint,
                "hv": hv,
                "driven": driven,
                "strict": strict,
                "quiet": quiet,
                "constr": constr,
                "nocursor": nocursor,
            },
        )

    def add_rect3(
        self,
        first: Argument,
        second: Argument,
        third: Argument,
        *,
        noconnect: bool = False,
        noconstraint: bool = False,
        driven: bool = False,
        strict: bool = False,
        quiet: bool = False,
        constr: bool = False,
        nocursor: bool = False,
    ) -> Any:
        """A rectangle from three corners in order, in any direction.

        As a command::

            add_rect3 p1 p2 p3 [driven] [strict] [noconnect] [noconstraint]
        """
        return self._command(
            "add_rect3",
            (first, second, third),
            {
                "noconnect": noconnect,
                "noconstraint": noconstraint,
                "driven": driven,
                "strict": strict,
                "quiet": quiet,
                "constr": constr,
                "nocursor": nocursor,
            },
        )

    def add_rectcenter(
        self,
        center: Argument,
        corner: Argument,
        *,
        noconnect: bool = False,
        noconstraint: bool = False,
        hv: bool = False,
        driven: bool = False,
        strict: bool = False,
        quiet: bool = False,
        constr: bool = False,
        nocursor: bool = False,
    ) -> Any:
        """A rectangle from its centre and one corner.

        As a command::

            add_rectcenter cx,cy px,py [hv] [driven] [strict] [noconnect] [noconstraint]
        """
        return self._command(
            "add_rectcenter",
            (center, corner),
            {
                "noconnect": noconnect,
                "noconstraint": noconstraint,
                "hv": hv,
                "driven": driven,
                "strict": strict,
                "quiet": quiet,
                "constr": constr,
                "nocursor": nocursor,
            },
        )

    def add_circle(
        self,
        center: Argument,
        radius: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        driven: bool = False,
    ) -> Any:
        """A circle from its centre and radius.

        As a command::

            add_circle cx,cy radius [noconnect] [nocursor] [driven] [quiet] [constr]
        """
        return self._command(
            "add_circle",
            (center, radius),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "driven": driven,
            },
        )

    def add_circle2(
        self,
        first: Argument,
        second: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        driven: bool = False,
    ) -> Any:
        """A circle from two opposite points on it.

        As a command::

            add_circle2 p1 p2 [noconnect] [nocursor] [driven]
        """
        return self._command(
            "add_circle2",
            (first, second),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "driven": driven,
            },
        )

    def add_circle3(
        self,
        first: Argument,
        second: Argument,
        third: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        driven: bool = False,
    ) -> Any:
        """A circle through three points.

        As a command::

            add_circle3 p1 p2 p3 [noconnect] [nocursor] [driven]
        """
        return self._command(
            "add_circle3",
            (first, second, third),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "driven": driven,
            },
        )

    def add_circle2t(
        self,
        first: Argument,
        second: Argument,
        radius: Argument,
        *,
        noconnect: bool = False,
        noconstraint: bool = False,
        driven: bool = False,
        strict: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A circle of a radius tangent to two lines.

        As a command::

            add_circle2t L0 L1 radius [noconnect] [noconstraint] [driven] [strict]
        """
        return self._command(
            "add_circle2t",
            (first, second, radius),
            {
                "noconnect": noconnect,
                "noconstraint": noconstraint,
                "driven": driven,
                "strict": strict,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
            },
        )

    def add_circle3t(
        self,
        first: Argument,
        second: Argument,
        third: Argument,
        *,
        noconnect: bool = False,
        noconstraint: bool = False,
        driven: bool = False,
        strict: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A circle tangent to three lines, such as the incircle of a triangle.

        As a command::

            add_circle3t L0 L1 L2 [noconnect] [noconstraint] [driven] [strict]
        """
        return self._command(
            "add_circle3t",
            (first, second, third),
            {
                "noconnect": noconnect,
                "noconstraint": noconstraint,
                "driven": driven,
                "strict": strict,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
            },
        )

    def add_arc(
        self,
        start: Argument,
        end: Argument,
        through: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
    ) -> Any:
        """A circular arc from its start to its end through a third point.

        As a command::

            add_arc start end through [noconnect] [notangent] [nocursor] [driven] [quiet]
                [constr]
        """
        return self._command(
            "add_arc",
            (start, end, through),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
            },
        )

    def add_ellipse(
        self,
        center: Argument,
        rx: Argument,
        ry: Argument,
        rotation: Argument | None = None,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        driven: bool = False,
    ) -> Any:
        """The command ``add_ellipse``.

        An ellipse from its centre, its two radii and the direction of the first, in degrees.

        As a command::

            add_ellipse cx,cy rx ry rotation [noconnect] [nocursor] [driven] [quiet] [constr]
        """
        return self._command(
            "add_ellipse",
            (center, rx, ry, rotation),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "driven": driven,
            },
        )

    def add_earc(
        self,
        first: Argument,
        second: Argument,
        rx: Argument,
        ry: Argument,
        rotation: Argument | None = None,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
        large: bool = False,
        cw: bool = False,
    ) -> Any:
        """An elliptic arc between two points, as in SVG: radii, rotation, large, clockwise.

        As a command::

            add_earc p1 p2 rx ry rotation [large] [cw] [noconnect] [notangent] [nocursor]
                [driven]
        """
        return self._command(
            "add_earc",
            (first, second, rx, ry, rotation),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
                "large": large,
                "cw": cw,
            },
        )

    def add_earc3(
        self,
        first: Argument,
        second: Argument,
        near: Argument,
        rx: Argument,
        ry: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
    ) -> Any:
        """An elliptic arc between two points with given radii that passes near a third.

        As a command::

            add_earc3 p1 p2 near rx ry [noconnect] [nocursor] [driven]
        """
        return self._command(
            "add_earc3",
            (first, second, near, rx, ry),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
            },
        )

    def add_earc_center(
        self,
        center: Argument,
        rx: Argument,
        ry: Argument,
        rotation: Argument,
        start: Argument,
        end: Argument,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
        cw: bool = False,
    ) -> Any:
        """The command ``add_earc_center``.

        An elliptic arc from its centre, radii, rotation, and start and end angle in degrees.

        As a command::

            add_earc_center cx,cy rx ry rotation start end [cw] [noconnect] [notangent]
                [nocursor] [driven]
        """
        return self._command(
            "add_earc_center",
            (center, rx, ry, rotation, start, end),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
                "cw": cw,
            },
        )

    def add_earc_tangent(
        self,
        start: Argument,
        first: Argument,
        end: Argument,
        last: Argument,
        bulge: Argument | None = None,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
    ) -> Any:
        """An elliptic arc from ends and directions.

        As a command::

            add_earc_tangent p1 t1 p2 t2 [bulge] [noconnect] [notangent] [nocursor] [driven]
        """
        return self._command(
            "add_earc_tangent",
            (start, first, end, last, bulge),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
            },
        )

    def add_earc_rtangent(
        self,
        end: Argument,
        last: Argument,
        bulge: Argument | None = None,
        *,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        notangent: bool = False,
        driven: bool = False,
    ) -> Any:
        """An elliptic arc that goes on from the last line or arc.

        As a command::

            add_earc_rtangent p2 t2 [bulge] [noconnect] [notangent] [nocursor] [driven]
        """
        return self._command(
            "add_earc_rtangent",
            (end, last, bulge),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "notangent": notangent,
                "driven": driven,
            },
        )

    def add_polygon(
        self,
        count: Argument,
        center: Argument,
        at: Argument,
        *,
        corner: bool = False,
        flat: bool = False,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A regular polygon of N sides about a centre.

        As a command::

            add_polygon N cx,cy px,py [corner] [flat] [quiet] [constr]
        """
        return self._command(
            "add_polygon",
            (count, center, at),
            {"corner": corner, "flat": flat, "quiet": quiet, "constr": constr},
        )

    def add_slot(
        self,
        first: Argument,
        second: Argument,
        radius: Argument,
        *,
        quiet: bool = False,
        constr: bool = False,
    ) -> Any:
        """A slot: two parallel lines and two half circles about two centres.

        As a command::

            add_slot x1,y1 x2,y2 RADIUS [quiet] [constr]
        """
        return self._command(
            "add_slot",
            (first, second, radius),
            {"quiet": quiet, "constr": constr},
        )

    def add_spline(
        self,
        *poles: Argument,
        noconnect: bool = False,
        nocursor: bool = False,
        quiet: bool = False,
        constr: bool = False,
        bezier: bool = False,
        through: bool = False,
    ) -> Any:
        """A cubic spline by its poles, or through points; it begins in the first.

        As a command::

            add_spline p1 p2 p3 p4 [p5 ...] [bezier] [noconnect] [nocursor] [quiet] [constr]
            add_spline p1 p2 p3 [p4 ...] through [noconnect] [nocursor] [quiet] [constr]
        """
        return self._command(
            "add_spline",
            (*poles,),
            {
                "noconnect": noconnect,
                "nocursor": nocursor,
                "quiet": quiet,
                "constr": constr,
                "bezier": bezier,
                "through": through,
            },
        )

    def split(self, entity: Argument, *where: Argument, nopin: bool = False) -> Any:
        """Cut a curve where others cross it; all pieces stay.

        As a command::

            split L0 x,y [r] [nopin]
            split L0 by L1 [L2 ...] [nopin]
        """
        return self._command("split", (entity, *where), {"nopin": nopin})

    def trim(
        self,
        entity: Argument,
        *where: Argument,
        nopin: bool = False,
        forward: bool = False,
        backward: bool = False,
    ) -> Any:
        """Cut a curve where others cross it, and delete one stretch.

        As a command::

            trim L0 x,y [r] [nopin]
            trim L0 by L1 L2 [nopin]
            trim L0 by L1 forward [nopin]
            trim L0 by L1 backward [nopin]
        """
        return self._command(
            "trim",
            (entity, *where),
            {"nopin": nopin, "forward": forward, "backward": backward},
        )

    def fillet(self, *corners: Argument, notangent: bool = False, noradius: bool = False) -> Any:
        """Round corners of lines with tangent arcs.

        As a command::

            fillet L1 L2 r [notangent] [noradius]
            fillet L1.p2 r
            fillet L1 L2 L3.p1 ... r
        """
        return self._command("fillet", (*corners,), {"notangent": notangent, "noradius": noradius})

    def chamfer(self, *corners: Argument) -> Any:
        """Bevel corners of lines.

        As a command::

            chamfer L1 L2 d
            chamfer L1.p2 d
            chamfer L1 L2 L3.p1 ... d
        """
        return self._command("chamfer", (*corners,), {})

    def delete(self, *names: Argument) -> Any:
        """Delete entities, constraints, dimensions, parameters, groups.

        As a command::

            delete L0 [C3 d0 M0 ...]
            delete selection
            delete M0 all
            delete L0 horizontal
            delete L0 L1 parallel
            delete L0.p2 L1.p1 coincident
        """
        return self._command("delete", (*names,), {})

    def drag(self, operand: Argument, to: Argument) -> Any:
        """Pull a point or a whole entity; the rest of the sketch follows.

        As a command::

            drag L0.p1 x,y
            drag L0.p2 @dx,dy
            drag L0 @dx,dy
            drag A0.center x,y
        """
        return self._command("drag", (operand, to), {})

    def extend(
        self,
        entity: Argument,
        *where: Argument,
        forward: bool = False,
        backward: bool = False,
        nopin: bool = False,
    ) -> Any:
        """Lengthen a line or arc up to another curve.

        As a command::

            extend L0 to L1 [forward] [backward] [nopin]
            extend L0 x,y [nopin]
            extend L0 forward [nopin]
        """
        return self._command(
            "extend",
            (entity, *where),
            {"forward": forward, "backward": backward, "nopin": nopin},
        )

    def lock(self, *points: Argument) -> Any:
        """Hold a point where it is, or at a place.

        As a command::

            lock P0
            lock L0.p1 [L0.p2 ...]
            lock L0.p1 x,y
        """
        return self._command("lock", (*points,), {})

    def unlock(self, *points: Argument) -> Any:
        """Let a locked point go.

        As a command::

            unlock P0
            unlock L0.p1 [L0.p2 ...]
        """
        return self._command("unlock", (*points,), {})

    def constr(self, *entities: Argument) -> Any:
        """Make entities construction geometry or ordinary again; toggle without `on`, `off`.

        As a command::

            constr L0 [L1 ...]
            constr L0 on
            constr L0 off
            constr selection
        """
        return self._command("constr", (*entities,), {})

    def quiet(self, *entities: Argument) -> Any:
        """The command ``quiet``.

        Hide the dimensions and centre of entities, or show them; toggle without `on`, `off`.

        As a command::

            quiet L0 [L1 ...]
            quiet L0 on
            quiet L0 off
            quiet selection
        """
        return self._command("quiet", (*entities,), {})

    def style(self, *words: Argument) -> Any:
        """Set the line style of entities, or ask for it.

        As a command::

            style L0 [L1 ...] solid
            style L0 dashed
            style L0 dashdot
            style L0
        """
        return self._command("style", (*words,), {})

    def mirror(self, *names: Argument, noconstraint: bool = False, strict: bool = False) -> Any:
        """Mirrored copies of entities about a line.

        As a command::

            mirror L0 [A0 P0 ...] about L1 [noconstraint] [strict]
            mirror selection about L1
        """
        return self._command("mirror", (*names,), {"noconstraint": noconstraint, "strict": strict})

    def offset(self, *words: Argument) -> Any:
        """Curves at a distance from a sequence of curves, which follow it.

        As a command::

            offset L0 [L1 A0 ...] DISTANCE [DISTANCE2] [left] [right] [flip] [symmetric]
                [inward] [outward] [round] [sharp] [caps line|round|none] [nopin] [constr]
                [quiet]
            offset sequence L0 DISTANCE ...
            offset selection DISTANCE ...
            offset M0 [DISTANCE [DISTANCE2]] [one] [two] [flip] [round] [caps none] [pin] ...
        """
        return self._command("offset", (*words,), {})

    def offset_line(
        self,
        line: Argument,
        distance: Argument,
        *,
        left: bool = False,
        right: bool = False,
        nopin: bool = False,
        constr: bool = False,
        quiet: bool = False,
    ) -> Any:
        """A parallel line at a distance from a line, which follows it.

        As a command::

            offset_line L0 DISTANCE [right] [nopin] [constr] [quiet]
        """
        return self._command(
            "offset_line",
            (line, distance),
            {"left": left, "right": right, "nopin": nopin, "constr": constr, "quiet": quiet},
        )

    def pattern(self, *words: Argument) -> Any:
        """Rigid copies in a circle or in a grid, which follow their sources.

        As a command::

            pattern circular L0 [A0 ...] about P0 N [full] [partial ANGLE] [symmetric ANGLE]
            pattern rect L0 [A0 ...] N DISTANCE [symmetric] [by N DISTANCE [symmetric]] [extent]
                [spacing] [along L5] [noalong] [one]
            pattern M0 ...
        """
        return self._command("pattern", (*words,), {})

    def rename(self, name: Argument, new_name: Argument) -> Any:
        """Rename an entity or dimension; everything that refers to it follows.

        As a command::

            rename L0 base1
            rename d0 width1
        """
        return self._command("rename", (name, new_name), {})

    def scale(self, *words: Argument) -> Any:
        """Scale entities uniformly about a point.

        As a command::

            scale L0 A0 ... about P0 FACTOR
            scale selection about x,y FACTOR
        """
        return self._command("scale", (*words,), {})

    def rotate(self, *words: Argument) -> Any:
        """Turn entities about a point, counter-clockwise in degrees.

        As a command::

            rotate L0 A0 ... about P0 ANGLE
            rotate selection about x,y ANGLE
        """
        return self._command("rotate", (*words,), {})

    def move(self, *words: Argument) -> Any:
        """Shift entities.

        As a command::

            move L0 A0 ... @dx,dy
            move L0 ... from P0 to x,y
            move selection @dx,dy
        """
        return self._command("move", (*words,), {})

    def horizontal(self, *operands: Argument, force: bool = False) -> Any:
        """Make lines, or two points, horizontal.

        As a command::

            horizontal L0 [L1 ...] [force]
            horizontal L0.p1 L1.p2 [force]
        """
        return self._command("horizontal", (*operands,), {"force": force})

    def vertical(self, *operands: Argument, force: bool = False) -> Any:
        """Make lines, or two points, vertical.

        As a command::

            vertical L0 [L1 ...] [force]
            vertical L0.p1 L1.p2 [force]
        """
        return self._command("vertical", (*operands,), {"force": force})

    def parallel(self, *operands: Argument, force: bool = False) -> Any:
        """Make lines parallel; of an ellipse the major axis counts.

        As a command::

            parallel L0 L1 [L2 ...] [force]
            parallel L0 EA0 [force]
            parallel EA0 EA1 [force]
        """
        return self._command("parallel", (*operands,), {"force": force})

    def perpendicular(self, *operands: Argument, force: bool = False) -> Any:
        """Make two lines perpendicular; of an ellipse the major axis counts.

        As a command::

            perpendicular L0 L1 [force]
            perpendicular L0 EA0 [force]
        """
        return self._command("perpendicular", (*operands,), {"force": force})

    def equal(self, *operands: Argument, force: bool = False) -> Any:
        """Equal length of lines, or equal radius of circles and arcs.

        As a command::

            equal L0 L1 [L2 ...] [force]
            equal A0 A1 [force]
        """
        return self._command("equal", (*operands,), {"force": force})

    def equal_angle(self, *operands: Argument, force: bool = False) -> Any:
        """The angle from L0 to L1 is that from L2 to L3.

        As a command::

            equal_angle L0 L1 L2 L3 [force]
        """
        return self._command("equal_angle", (*operands,), {"force": force})

    def collinear(self, *operands: Argument, force: bool = False) -> Any:
        """Put lines on one straight line.

        As a command::

            collinear L0 L1 [L2 ...] [force]
        """
        return self._command("collinear", (*operands,), {"force": force})

    def tangent(
        self,
        *operands: Argument,
        outside: bool = False,
        inside: bool = False,
        force: bool = False,
    ) -> Any:
        """Make a line and an arc, two arcs, or two ends that meet, tangent.

        As a command::

            tangent L0 A0 [force]
            tangent A0 A1 [outside] [inside] [force]
            tangent L0.p2 S0.p1 [force]
        """
        return self._command(
            "tangent",
            (*operands,),
            {"outside": outside, "inside": inside, "force": force},
        )

    def smooth(self, *operands: Argument, force: bool = False) -> Any:
        """The same curvature at two ends that meet.

        As a command::

            smooth S0.p2 S1.p1 [force]
        """
        return self._command("smooth", (*operands,), {"force": force})

    def coincident(self, *operands: Argument, force: bool = False) -> Any:
        """Put two points at one place.

        As a command::

            coincident L0.p2 L1.p1 [force]
        """
        return self._command("coincident", (*operands,), {"force": force})

    def concentric(self, *operands: Argument, force: bool = False) -> Any:
        """One centre for circles, arcs, ellipses.

        As a command::

            concentric A0 A1 [A2 ...] [force]
        """
        return self._command("concentric", (*operands,), {"force": force})

    def point_on(self, *operands: Argument, force: bool = False) -> Any:
        """Put a point on a line (also beyond its ends) or a curve.

        As a command::

            point_on P0 L0 [force]
            point_on L0.p1 A0 [force]
            point_on A0.center L0 [force]
        """
        return self._command("point_on", (*operands,), {"force": force})

    def midpoint(self, *operands: Argument, force: bool = False) -> Any:
        """Put a point in the middle of a line or an arc.

        As a command::

            midpoint P0 L0 [force]
            midpoint L0.p1 A0 [force]
        """
        return self._command("midpoint", (*operands,), {"force": force})

    def symmetry(self, *operands: Argument, force: bool = False) -> Any:
        """The command ``symmetry``.

        Make two points, lines or arcs mirror images about a line or a point, the middle
        operand.

        As a command::

            symmetry P0 L0 P1 [force]
            symmetry L0 L1 L2 [force]
            symmetry A0 L0 A1 [force]
            symmetry P0 P1 P2 [force]
        """
        return self._command("symmetry", (*operands,), {"force": force})

    def on_normal(self, *operands: Argument, force: bool = False) -> Any:
        """Put a point on the normal of a curve at the curve's end.

        As a command::

            on_normal L1.p2 L0.p2 [force]
            on_normal A1.start A0.start [force]
        """
        return self._command("on_normal", (*operands,), {"force": force})

    def fix(self, *operands: Argument, force: bool = False) -> Any:
        """Hold all numbers of entities as they are.

        As a command::

            fix L0 [L1 ...] [force]
        """
        return self._command("fix", (*operands,), {"force": force})

    def image(self, source: Argument, copy: Argument, *words: Argument, force: bool = False) -> Any:
        """Hold an entity as a turned or shifted copy of another one of its kind.

        As a command::

            image L0 L1 rotate ANGLE [about P0] [force]
            image L0 L1 shift dx,dy [force]
        """
        return self._command("image", (source, copy, *words), {"force": force})

    def switch_off(self, *names: Argument) -> Any:
        """Let constraints and dimensions not act; they stay listed.

        As a command::

            switch_off C3 [d0 ...]
        """
        return self._command("switch_off", (*names,), {})

    def switch_on(self, *names: Argument) -> Any:
        """Let constraints and dimensions act again that were switched off.

        As a command::

            switch_on C3 [d0 ...]
        """
        return self._command("switch_on", (*names,), {})

    def length(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Length of a line.

        As a command::

            length L0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "length",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def distance(
        self,
        first: Argument,
        second: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Distance of two points, lines or circles, or of one and another.

        As a command::

            distance L0.p1 L1.p2 VALUE [derived] [driven] [force]
            distance P0 L0 VALUE [derived] [driven] [force]
            distance L0 L1 VALUE [derived] [driven] [force]
            distance A0 A1 VALUE [derived] [driven] [force]
            distance L0 A0 VALUE [derived] [driven] [force]
            distance P0 A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "distance",
            (first, second, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def hdistance(
        self,
        first: Argument,
        second: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Distance of two points along x; which is on the left stays.

        As a command::

            hdistance L0.p1 L1.p2 VALUE [derived] [driven] [force]
        """
        return self._command(
            "hdistance",
            (first, second, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def vdistance(
        self,
        first: Argument,
        second: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Distance of two points along y; which is above stays.

        As a command::

            vdistance L0.p1 L1.p2 VALUE [derived] [driven] [force]
        """
        return self._command(
            "vdistance",
            (first, second, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def radius(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Radius of a circle or arc; first radius of an ellipse.

        As a command::

            radius A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "radius",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def diameter(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Diameter of a circle or arc.

        As a command::

            diameter A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "diameter",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def radius_b(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Second radius of an ellipse.

        As a command::

            radius_b EA0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "radius_b",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def sweep(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Angle of an arc from start to end.

        As a command::

            sweep A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "sweep",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def arc_length(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Length along an arc.

        As a command::

            arc_length A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "arc_length",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def angle(
        self,
        first: Argument,
        second: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
        supplement: bool = False,
        closest: bool = False,
        acute: bool = False,
        obtuse: bool = False,
    ) -> Any:
        """Angle between the directions of two lines.

        As a command::

            angle L0 L1 VALUE [supplement] [closest] [acute] [obtuse] [derived] [driven] [force]
        """
        return self._command(
            "angle",
            (first, second, value),
            {
                "derived": derived,
                "driven": driven,
                "force": force,
                "supplement": supplement,
                "closest": closest,
                "acute": acute,
                "obtuse": obtuse,
            },
        )

    def xangle(
        self,
        entity: Argument,
        value: Argument | None = None,
        *,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Angle of a line or of an ellipse's major axis from the x axis, counter-clockwise.

        As a command::

            xangle L0 VALUE [derived] [driven] [force]
            xangle EA0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "xangle",
            (entity, value),
            {"derived": derived, "driven": driven, "force": force},
        )

    def total_length(
        self,
        *operands: Argument,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Length of a chain of curves.

        As a command::

            total_length L0 L1 A0 VALUE [derived] [driven] [force]
        """
        return self._command(
            "total_length",
            (*operands,),
            {"derived": derived, "driven": driven, "force": force},
        )

    def area(
        self,
        *operands: Argument,
        derived: bool = False,
        driven: bool = False,
        force: bool = False,
    ) -> Any:
        """Area inside of a closed chain of curves.

        As a command::

            area L0 L1 L2 VALUE [derived] [driven] [force]
        """
        return self._command(
            "area",
            (*operands,),
            {"derived": derived, "driven": driven, "force": force},
        )

    def set_derived(self, dimension: Argument) -> Any:
        """Let a dimension only measure.

        As a command::

            set_derived d0
        """
        return self._command("set_derived", (dimension,), {})

    def set_driven(self, dimension: Argument, value: Argument | None = None) -> Any:
        """Let a dimension hold its quantity: at the present value, or at another one.

        As a command::

            set_driven d0
            set_driven d0 VALUE
        """
        return self._command("set_driven", (dimension, value), {})

    def dim_pos(self, dimension: Argument, direction: Argument, value: Argument) -> Any:
        """Place the text of a dimension: away from the geometry, or along it.

        As a command::

            dim_pos d0 offset 1.5
            dim_pos d0 along 0.3
            dim_pos d0 offset @0.5
        """
        return self._command("dim_pos", (dimension, direction, value), {})

    def freeze(self, *entities: Argument) -> Any:
        """Add dimensions at the present values to all lines and arcs, or to some.

        As a command::

            freeze
            freeze L0 A0 ...
        """
        return self._command("freeze", (*entities,), {})

    def param(self, name: Argument, value: Argument) -> Any:
        """Make a parameter, or give it another value.

        As a command::

            param width 10
            param height width * 2
        """
        return self._command("param", (name, value), {})

    def del_param(self, name: Argument) -> Any:
        """Delete a parameter.

        As a command::

            del_param width
        """
        return self._command("del_param", (name,), {})

    def rename_param(self, name: Argument, new_name: Argument) -> Any:
        """Rename a parameter; expressions that read it follow.

        As a command::

            rename_param width w
        """
        return self._command("rename_param", (name, new_name), {})

    def select(
        self,
        *names: Argument,
        chain: bool = False,
        linked: bool = False,
        sequence: bool = False,
    ) -> Any:
        """Add to the selection, or select everything that hangs together.

        As a command::

            select L0 [L0.p1 A0.center ...]
            select all
            select L0 chain
            select L0 linked
            select L0 sequence
            select M0
        """
        return self._command(
            "select",
            (*names,),
            {"chain": chain, "linked": linked, "sequence": sequence},
        )

    def deselect(self, *names: Argument) -> Any:
        """Clear the selection, or take something out of it.

        As a command::

            deselect
            deselect L0 ...
        """
        return self._command("deselect", (*names,), {})

    def explain(self, *command: Argument) -> Any:
        """Say what a command would do, without doing it.

        As a command::

            explain <command>
        """
        return self._command("explain", (*command,), {})

    def print(self, *expressions: Argument) -> Any:
        """Show the value of expressions, coordinates and variables.

        As a command::

            print EXPRESSION ...
        """
        return self._command("print", (*expressions,), {})

    def info(self, name: Argument) -> Any:
        """Show everything about one thing, and what refers to it.

        As a command::

            info L0
            info L0.p1
            info C3
            info d0
            info width
            info M0
        """
        return self._command("info", (name,), {})

    def list(self, kind: Argument | None = None) -> Any:
        """List what there is, of all kinds or of one.

        As a command::

            list
            list lines
            list dims
            list parallel
            list radius
        """
        return self._command("list", (kind,), {})

    def find(self, at: Argument, radius: Argument | None = None) -> Any:
        """Find points and entities near a place.

        As a command::

            find x,y
            find x,y radius
        """
        return self._command("find", (at, radius), {})

    def dof(self, what: Argument | None = None) -> Any:
        """Count the degrees of freedom, or look into them.

        As a command::

            dof
            dof analyze
            dof eigenvalues
            dof singular
            dof jacobian
        """
        return self._command("dof", (what,), {})

    def free(self) -> Any:
        """Say in words what can still move.

        As a command::

            free
        """
        return self._command("free", (), {})

    def why(self, name: Argument) -> Any:
        """List what holds an entity or a point.

        As a command::

            why L0
            why L0.p1
        """
        return self._command("why", (name,), {})

    def what_if(self, *command: Argument) -> Any:
        """Say what a command would change: freedoms, and how far things move.

        As a command::

            what_if <command>
        """
        return self._command("what_if", (*command,), {})

    def sensitivity(self, dimension: Argument, entity: Argument | None = None) -> Any:
        """Say how far entities move per unit of a dimension.

        As a command::

            sensitivity d0
            sensitivity d0 L3
        """
        return self._command("sensitivity", (dimension, entity), {})

    def cost(self) -> Any:
        """Show how well the constraints hold: half the sum of squared residuals.

        As a command::

            cost
        """
        return self._command("cost", (), {})

    def measure(self, first: Argument, second: Argument | None = None) -> Any:
        """Measure one entity, or how two lie to each other.

        As a command::

            measure L0
            measure L0 L1
            measure P0 L0
            measure L0 A0
        """
        return self._command("measure", (first, second), {})

    def undo(self, steps: Argument | None = None) -> Any:
        """Take the last command line back, or several.

        As a command::

            undo
            undo 5
        """
        return self._command("undo", (steps,), {})

    def redo(self, steps: Argument | None = None) -> Any:
        """Make what was undone again.

        As a command::

            redo
            redo 3
        """
        return self._command("redo", (steps,), {})

    def history(self, count: Argument | None = None) -> Any:
        """List the steps; `>` marks the last one that is done.

        As a command::

            history
            history 10
        """
        return self._command("history", (count,), {})

    def goto(self, step: Argument) -> Any:
        """Go to a step of the history; 0 is the start.

        As a command::

            goto 5
            goto 0
        """
        return self._command("goto", (step,), {})

    def center(self, what: Argument | None = None) -> Any:
        """Show everything, or put an entity or a place into the middle of the view.

        As a command::

            center
            center L0
            center 5,3
        """
        return self._command("center", (what,), {})

    def zoom(self, factor: Argument) -> Any:
        """Zoom in, out, or to a factor; 1 shows everything.

        As a command::

            zoom +
            zoom -
            zoom 2.0
        """
        return self._command("zoom", (factor,), {})

    def cursor(self, at: Argument | None = None) -> Any:
        """Show or set the cursor, from which `@dx,dy` starts.

        As a command::

            cursor
            cursor 5,3
            cursor L0.p2
            cursor @dx,dy
            cursor on
            cursor off
        """
        return self._command("cursor", (at,), {})

    def show(self) -> Any:
        """Show the cursor, at 0,0 if it is not set: `cursor on`.

        As a command::

            show
        """
        return self._command("show", (), {})

    def hide(self) -> Any:
        """Hide the cursor: `cursor off`.

        As a command::

            hide
        """
        return self._command("hide", (), {})

    def clear(self) -> Any:
        """Delete everything; names begin anew. `undo` brings it back.

        As a command::

            clear
        """
        return self._command("clear", (), {})

    def help(self, topic: Argument | None = None) -> Any:
        """Show the commands, one command, or the whole manual.

        As a command::

            help
            help full
            help COMMAND
            help GROUP
            help coordinates
        """
        return self._command("help", (topic,), {})

    def msg(self, text: Argument) -> Any:
        r"""Show a text, as Markdown; `\n` begins a new line.

        As a command::

            msg TEXT
        """
        return self._command("msg", (text,), {})

    def timing(self, switch: Argument | None = None) -> Any:
        """Show how long every command line takes.

        As a command::

            timing on
            timing off
            timing
        """
        return self._command("timing", (switch,), {})

    def settings(
        self,
        name: Argument | None = None,
        value: Argument | None = None,
        how: Argument | None = None,
    ) -> Any:
        """Show the switches, or set one; `unit` is that of lengths: mm, cm, m, in.

        As a command::

            settings
            settings NAME on
            settings NAME off
            settings unit in convert
        """
        return self._command("settings", (name, value, how), {})

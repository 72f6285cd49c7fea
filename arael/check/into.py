"""Rule: the blocks listed in `into` are those that the constraint contributes to.

Each pair of entities whose parameters a residual reads together is coupled, and needs a named cross
block or `triplets` of the root. Contributions to the diagonal need not be listed; a self block in
the list states whose parameters the constraint reads.

Allowed: ``into hb`` for one entity or one pair; ``into [hb_ab, hb_ac, hb_bc]`` for three;
``into pose.hb_pose`` through a ref; ``into [hb_pose, root.hbt]`` where root parameters are read.

Not allowed: a pair left out; a block of an entity whose parameters are not read; a block twice; a
cross block of another row; triplets if every pair has a block.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import combinations

from arael.check.binding import Collection, Entity
from arael.check.blocks import NamedBlock
from arael.check.paths import Paths
from arael.check.places import Place, Sites
from arael.check.report import Reporter
from arael.check.suggest import did_you_mean
from arael.check.typed import ConstraintSite, Read
from arael.check.walk import postorder
from arael.diagnostics.records import Label
from arael.runtime.layout import Step
from arael.syntax import tree

# An entity relative to the constraint's row: the path to its row, and its prefix there.
Key = tuple[tuple[Step, ...], str]
Pair = frozenset[Key]
Blocks = dict[Place, dict[str, NamedBlock]]


@dataclass
class Into:
    """The pairs that the blocks of one constraint cover, and the name of triplets.

    `selves` are the entities whose self blocks are named.
    """

    selves: list[tuple[Key, tree.Path]] = field(default_factory=list)
    crossed: dict[Pair, tree.Path] = field(default_factory=dict)
    triplets: str = ""
    where: tree.Path | None = None
    good: bool = True


class IntoRule:
    """Checks the `into` clauses of a model; `blocks` maps the identity of a place to its blocks."""

    def __init__(self, sites: Sites, paths: Paths, blocks: Blocks, report: Reporter) -> None:
        self.sites = sites
        self.paths = paths
        self.blocks = blocks
        self.report = report

    def check(
        self, place: Place, node: tree.Constraint, site: ConstraintSite | None
    ) -> ConstraintSite | None:
        """The constraint with the pairs that its blocks cover, if it has `into`; reports errors."""
        if not node.into:
            return site
        into = Into()
        seen: dict[str, tree.Path] = {}
        for path in node.into:
            if str(path) in seen:
                self._wrong(
                    path,
                    f"`{path}` is named twice",
                    "again here",
                    [Label(seen[str(path)].span, "first named here")],
                    ["name it once"],
                )
                into.good = False
            else:
                seen[str(path)] = path
                self._entry(Entity((), place), path, into)
        if site is not None and into.good:
            self._fit(place, node, site, into)
            site = _covered(site, into)
        return site

    # --- named blocks -------------------------------------------------------------------------

    def _entry(self, home: Entity, path: tree.Path, into: Into) -> None:
        *before, last = path.parts
        holder: Entity | None = home
        if before:
            leading = tree.Path(parts=tuple(before), span=path.span)
            target = self.paths.walk(home, leading, own=True)
            holder = target if isinstance(target, Entity) else None
            if isinstance(target, Collection):
                name = target.site.place.struct.name
                self.report.error(
                    "E0410",
                    path.span,
                    f"`{leading}` is a collection",
                    label=f"the block of which {name}?",
                    help=[f"go through a ref: `x: ref {name} in {leading}`, `into x.{last.id}`"],
                )
        named = None if holder is None else self._named(home, holder, path, last)
        if holder is None or named is None:
            into.good = False
            return
        if named.kind == "triplets":
            into.triplets, into.where = last.id, path
        elif named.kind == "self":
            into.selves.append(((holder.steps, holder.place.prefix), path))
        elif not holder.same(home):
            self._remote_cross(path, last, named, holder)
            into.good = False
        else:
            pair = frozenset((e.steps, e.place.prefix) for e in named.ends)
            into.crossed[pair] = path

    def _named(
        self, home: Entity, holder: Entity, path: tree.Path, last: tree.Ident
    ) -> NamedBlock | None:
        struct = holder.place.struct
        declared = struct.fields.get(last.id)
        if declared is None:
            if last.id not in self.sites.declarations.broken:
                self._unknown(home, holder, path, last)
        elif declared.kind not in ("block", "triplets"):
            self.report.error(
                "E0410",
                last.span,
                f"`{path}` is not a block",
                label=f"this is `{declared.text}`",
                labels=[Label(declared.span, "declared here")],
            )
        return self.blocks[holder.place].get(last.id)

    def _unknown(self, home: Entity, holder: Entity, path: tree.Path, last: tree.Ident) -> None:
        struct = holder.place.struct
        blocks = [f.name for f in struct.fields.values() if f.kind in ("block", "triplets")]
        root = self.sites.root.place.struct
        help_ = did_you_mean(last.id, blocks)
        if len(path.parts) == 1 and last.id in root.fields and struct is not root:
            help_ = [f"the root has a `{last.id}`: write `root.{last.id}`"]
        self.report.error(
            "E0410",
            last.span,
            f"{struct.name} has no block `{last.id}`",
            label="unknown block",
            help=help_ or ["omit `into`: blocks are inferred without it"],
        )

    def _remote_cross(
        self, path: tree.Path, last: tree.Ident, named: NamedBlock, holder: Entity
    ) -> None:
        struct = holder.place.struct.name
        self.report.error(
            "E0432",
            path.span,
            f"`{path}` is a cross block of another row",
            label=f"belongs to that {struct}",
            labels=[Label(named.field.span, "declared here")],
            help=[
                "declare a block of the pair next to this constraint, or use "
                "`triplets` of the root; only self blocks can be named through a ref"
            ],
        )

    # --- validation ---------------------------------------------------------------------------

    def _fit(self, place: Place, node: tree.Constraint, site: ConstraintSite, into: Into) -> None:
        read: dict[Key, Place] = {}
        coupled: dict[Pair, tuple[Key, Key]] = {}
        for part in site.residual:
            here: dict[Key, Place] = {}
            for one in postorder([part]):
                if isinstance(one, Read) and one.version == "trial" and one.parameter:
                    entity = self._entity(site, one)
                    here[site.slots[one.slot].steps, entity.prefix] = entity
            read.update(here)
            coupled.update({frozenset(pair): pair for pair in combinations(here, 2)})
            # Rows that a sum runs over are coupled with each other.
            coupled.update({frozenset([k]): (k, k) for k in here if _is_summed(k)})

        entity_names = {key: _entity_name(key, entity) for key, entity in read.items()}
        reads = "it reads parameters of " + _listed([f"{entity_names[key]}" for key in read])
        for key, path in into.selves:
            if key not in read:
                self._wrong(
                    path,
                    f"`{path}` is not a block of this constraint",
                    "it reads no parameter of that entity",
                    notes=[reads],
                    help=[f"remove `{path}`: a constraint adds nothing to it"],
                )
        for pair, path in into.crossed.items():
            if not pair <= read.keys():
                self._wrong(
                    path,
                    f"`{path}` is not a block of this constraint",
                    "it does not read parameters of both ends",
                    notes=[reads],
                    help=[self._instead(place, read, f"remove `{path}`")],
                )
        left = [pair for key, pair in coupled.items() if key not in into.crossed]
        if into.triplets:
            if not left and into.where is not None:
                self._wrong(
                    into.where,
                    f"`{into.where}` receives no pair",
                    "every pair has a block" if coupled else "no two are coupled",
                    notes=[reads],
                    help=[f"remove `{into.where}`"],
                )
            return
        for a, b in left:
            self._missing(place, node, (a, read[a]), (b, read[b]), entity_names)

    def _missing(
        self,
        place: Place,
        node: tree.Constraint,
        a: tuple[Key, Place],
        b: tuple[Key, Place],
        entity_names: dict[Key, str],
    ) -> None:
        last = node.into[-1]
        root = self.sites.root.place.struct
        names = [_in_block(key, entity) for key, entity in (a, b)]
        paths = [str(path) for path in node.into]
        helps = []
        if all(names):
            shown = ", ".join([*paths, "hb_cross"])
            helps.append(
                f"declare `hb_cross: block ({names[0]}, {names[1]})` in {place.struct.name} and "
                f"write `into [{shown}]`"
            )
        triplets = next((f.name for f in root.fields.values() if f.kind == "triplets"), "")
        declare = "" if triplets else f"declare `hbt: triplets` in {root.name} and "
        shown = ", ".join([*paths, f"root.{triplets or 'hbt'}"])
        helps.append(f"{declare}write `into [{shown}]`")
        helps.append("or omit `into`: blocks are inferred without it")
        what = f"{entity_names[a[0]]} and {entity_names[b[0]]}"
        if a[0] == b[0]:
            what = f"rows of {entity_names[a[0]]}"
        self.report.error(
            "E0431",
            last.span,
            f"the constraint couples {what}, but `into` has no block of the two",
            label="a block is missing",
            labels=[Label(node.name.span, "this constraint")],
            help=helps,
        )

    def _instead(self, place: Place, read: dict[Key, Place], otherwise: str) -> str:
        """Help for a cross block named by a constraint on one entity."""
        if len(read) != 1:
            return otherwise
        ((steps, _), entity) = next(iter(read.items()))
        self_blocks = [n for n, b in self.blocks[entity].items() if b.kind == "self"]
        way = ".".join(s.shown for s in steps)
        if not self_blocks:
            return f"declare `hb: block {entity.struct.name}` in {entity.struct.name} and name that"
        return f"write `into {f'{way}.' if way else ''}{self_blocks[0]}`"

    def _entity(self, site: ConstraintSite, read: Read) -> Place:
        """The place whose parameter is read: the innermost one that contains the column."""
        table = self.sites.tables[site.slots[read.slot].table]
        around = [
            p for p in table.places() if read.column.startswith(p.prefix) and not p.struct.component
        ]
        return max(around, key=lambda p: len(p.prefix))

    def _wrong(
        self,
        path: tree.Path,
        message: str,
        label: str,
        labels: list[Label] | None = None,
        help: list[str] | None = None,
        notes: list[str] | None = None,
    ) -> None:
        self.report.error(
            "E0431",
            path.span,
            message,
            label=label,
            labels=labels or [],
            notes=notes or [],
            help=help or [],
        )


def _is_summed(key: Key) -> bool:
    """Whether an entity is one of many rows that a sum runs over."""
    return any(step.kind == "rows" for step in key[0])


def _covered(site: ConstraintSite, into: Into) -> ConstraintSite:
    return replace(site, triplets=into.triplets, crossed=tuple(into.crossed))


def _entity_name(key: Key, place: Place) -> str:
    """An entity by its name in the model: `pose`, the parent, the root."""
    steps, _ = key
    inner = place.prefix.removesuffix(".")
    if not steps:
        return f"this {place.struct.name}"
    if steps == (Step("root"),):
        return f"`root.{inner}`" if inner else f"the root {place.struct.name}"
    way = ".".join(s.shown for s in steps)
    return f"`{way}.{inner}`" if inner else f"`{way}`"


def _in_block(key: Key, place: Place) -> str:
    """The name of an entity in `block (...)`; "" if it has none."""
    steps, _ = key
    if len(steps) == 1 and steps[0].kind == "ref" and not place.prefix:
        name, _, element = steps[0].ref.rpartition(".")
        if not name:
            return element
        return f"{name}[{element}]" if element.isdecimal() and "." not in name else ""
    if all(s.kind not in ("ref", "rows") for s in steps):
        return place.struct.name
    return ""


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)

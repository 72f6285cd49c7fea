"""Going from entity to entity: to the owner, into a struct held by value, through a ref."""

from __future__ import annotations

from dataclasses import replace

from arael.check.binding import BROKEN, Broken, Collection, Entity
from arael.check.declared import FieldDecl
from arael.check.limits import MAX_REFS
from arael.check.places import Place, Sites
from arael.check.report import Reporter
from arael.check.suggest import nearest
from arael.diagnostics.records import Label
from arael.runtime.layout import Step, Target
from arael.syntax import tree

ROOT_STEPS = (Step("root"),)


class Paths:
    """Resolves refs and paths over the places of a model."""

    def __init__(self, sites: Sites, report: Reporter) -> None:
        self.sites = sites
        self.report = report
        self.open: list[tuple[Place, FieldDecl]] = []
        self.taken = 0  # refs needed so far by the one being resolved
        self.bad: set[tuple[Place, str]] = set()

    @property
    def root_name(self) -> str:
        """The root's name as constraints write it."""
        return self.sites.root.place.struct.name.lower()

    def root(self, home: Entity) -> Entity:
        """The root, as reached from `home`."""
        at_root = not home.steps and home.place.table is self.sites.root
        return Entity(() if at_root else ROOT_STEPS, self.sites.root.place)

    def owner(self, entity: Entity) -> Entity | None:
        """The entity that contains this one; None for the root."""
        place = entity.place
        if place.owner is None:
            return None
        if place.prefix:
            return replace(entity, place=place.owner)
        if entity.holder is not None:
            return entity.holder
        if place.owner.table is self.sites.root:
            return Entity(ROOT_STEPS, place.owner)
        return Entity((*entity.steps, Step("parent")), place.owner, needs=entity.needs)

    def follow(self, entity: Entity, field: FieldDecl) -> Entity | Broken:
        """The entity that the ref `field` of `entity` points to."""
        collection = self.resolve(entity, field)
        if isinstance(collection, Broken):
            return BROKEN
        column = entity.place.column(field)
        needs = (*entity.needs, (entity, column)) if field.optional else entity.needs
        steps = (*entity.steps, Step("ref", column))
        return Entity(steps, collection.site.place, collection.owner, needs)

    def target(self, place: Place, field: FieldDecl) -> Target | None:
        """The target of the ref `field` of a row at `place`; None after an error."""
        collection = self.resolve(Entity((), place), field)
        if isinstance(collection, Broken):
            return None
        assert isinstance(field.node.type, tree.RefType)
        owner = collection.owner
        base = ROOT_STEPS if owner.place.table is self.sites.root else owner.steps
        return Target(collection.site.path, field.struct, base, str(field.node.type.path))

    def resolve(self, entity: Entity, field: FieldDecl) -> Collection | Broken:
        """The target collection of the ref `field` of `entity`."""
        key = (entity.place, field.name.partition(".")[0])  # once for all elements of a list
        if key in self.bad:
            return BROKEN
        self.taken = self.taken + 1 if self.open else 0
        if (entity.place, field) in self.open or self.taken > MAX_REFS:
            self._circle(field)
            self.bad.add(key)
            return BROKEN
        self.open.append((entity.place, field))
        target = self._resolve(entity, field)
        self.open.pop()
        if isinstance(target, Broken):
            self.bad.add(key)
        return target

    def _resolve(self, entity: Entity, field: FieldDecl) -> Collection | Broken:
        assert isinstance(field.node.type, tree.RefType)
        target = self.walk(entity, field.node.type.path, own=True)
        if isinstance(target, Broken):
            return BROKEN
        path = field.node.type.path
        if isinstance(target, Entity):
            self.report.error(
                "E0403",
                path.span,
                f"`{path}` is not a collection",
                label=f"this is a single {target.place.struct.name}",
                help=["a ref points into a `list of`, `deque of` or `arena of`"],
            )
            return BROKEN
        held = target.site.place.struct
        if held.name != field.struct:
            declared = target.site.declared
            assert declared is not None
            self.report.error(
                "E0404",
                field.node.type.target.span,
                f"`{path}` holds {held.name}, not {field.struct}",
                label=f"expected {held.name}",
                labels=[Label(declared.span, f"declared as `{declared.text}` here")],
                help=[f"write `ref {held.name} in {path}`"],
            )
            return BROKEN
        return target

    def walk(
        self, home: Entity, path: tree.Path, *, own: bool, through: bool = False
    ) -> Entity | Collection | Broken:
        """The target of `path` from `home`.

        With `own` it may start at a field of `home`; it may always start at ``root``, ``parent`` or
        the root's name. With `through` it may pass through a collection, meaning every element.
        """
        here: Entity | Collection = home
        for i, part in enumerate(path.parts):
            if isinstance(here, Collection):
                if not through:
                    return self._through_collection(path, i, here)
                here = Entity((), here.site.place)
            reached = self._first(home, part, own) if i == 0 else self._part(here, part, path)
            if isinstance(reached, Broken):
                return BROKEN
            here = reached
        return here

    def _first(self, home: Entity, part: tree.Ident, own: bool) -> Entity | Collection | Broken:
        if part.id == "self":
            return home
        if own and part.id in home.place.struct.fields:
            return self._field(home, home.place.struct.fields[part.id], part)
        if part.id in ("root", self.root_name):
            return self.root(home)
        if part.id == "parent":
            return self._owner(home, part)
        names = [*home.place.struct.fields, "root", "parent"]
        near = nearest(part.id, names)
        on_root = self.sites.root.place.struct.fields
        hints = [f"did you mean `{near}`?"] if near else []
        if part.id in on_root:
            hints = [f"the root has a `{part.id}`: write `root.{part.id}`"]
        self.report.error(
            "E0405",
            part.span,
            f"unknown start of a path: `{part.id}`",
            label="not a field of this struct",
            help=hints or ["start at `root`, `parent` or another ref of this struct"],
        )
        return BROKEN

    def _part(
        self, here: Entity, part: tree.Ident, path: tree.Path
    ) -> Entity | Collection | Broken:
        if part.id == "parent":
            return self._owner(here, part)
        fields = here.place.struct.fields
        if part.id not in fields:
            near = nearest(part.id, fields)
            self.report.error(
                "E0405",
                part.span,
                f"{here.place.struct.name} has no field `{part.id}`",
                label=f"unknown part of `{path}`",
                labels=[Label(here.place.struct.node.name.span, "this struct")],
                help=[f"did you mean `{near}`?"] if near else [],
            )
            return BROKEN
        return self._field(here, fields[part.id], part)

    def _field(
        self, here: Entity, field: FieldDecl, part: tree.Ident
    ) -> Entity | Collection | Broken:
        if field.kind == "struct":
            return Entity(here.steps, here.place.values[field.name], here.holder, here.needs)
        if field.kind == "collection":
            return Collection(here, here.place.collections[field.name])
        if field.kind == "ref":
            return self.follow(here, field)
        self.report.error(
            "E0403",
            part.span,
            f"`{part.id}` is not a collection",
            label=f"this is `{field.text}`",
            labels=[Label(field.span, "declared here")],
            help=["a path leads through structs and refs to a collection"],
        )
        return BROKEN

    def _owner(self, here: Entity, part: tree.Ident) -> Entity | Broken:
        owner = self.owner(here)
        if owner is None:
            self.report.error(
                "E0405",
                part.span,
                f"{here.place.struct.name} has no parent",
                label="the root has no owner",
            )
            return BROKEN
        return owner

    def _through_collection(self, path: tree.Path, i: int, here: Collection) -> Broken:
        name = here.site.place.struct.name
        before = ".".join(p.id for p in path.parts[:i])
        self.report.error(
            "E0403",
            path.parts[i].span,
            f"`{before}` is a collection; `{path.parts[i].id}` belongs to one of its elements",
            label="element not specified",
            help=[f"add `x: ref {name} in {before}` and write `x.{path.parts[i].id}`"],
        )
        return BROKEN

    def _circle(self, field: FieldDecl) -> None:
        if self.taken > MAX_REFS:
            self.report.error(
                "E0406",
                self.open[0][1].span,
                f"ref is resolved through more than {MAX_REFS} others",
                label="the chain is too long",
                help=["start the path at `root` or `parent`"],
            )
            return
        names = [f.name for _, f in self.open]
        start = names.index(field.name)
        circle = " -> ".join([*names[start:], field.name])
        self.report.error(
            "E0406",
            field.span,
            f"refs are resolved through each other: {circle}",
            label="resolving this ref requires itself",
            help=["start one of the paths at `root` or `parent`"],
        )

"""From the syntax tree of a model to its typed schema: the rules, in order."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from typing import Any

from arael.check.blocks import check_blocks, named_blocks
from arael.check.bodies import Bodies, fit_names
from arael.check.components import Components, check_members
from arael.check.constants import Constants
from arael.check.containment import check_containment
from arael.check.declared import Declarations
from arael.check.fields import Fields, declare_fields
from arael.check.fixed import apply_fixed
from arael.check.inlining import check_functions
from arael.check.into import Blocks, IntoRule
from arael.check.items import Load, choose_root, gather
from arael.check.marginalize import check_marginalize
from arael.check.members import check_keys, sort_members
from arael.check.passes import Passes
from arael.check.paths import Paths
from arael.check.places import Sites
from arael.check.report import Reporter
from arael.check.scalar_functions import source_text, type_functions
from arael.check.tables import build_blocks, build_entities, build_tables, check_refs
from arael.check.typed import ConstraintSite, TypedModel
from arael.check.usage import (
    warn_lost_derivatives,
    warn_unread_parameters,
    warn_unused_structs,
    warn_unwrapped_angles,
)
from arael.diagnostics.records import Findings
from arael.syntax import tree


def check(
    file: tree.File,
    *,
    load: Load | None = None,
    root: str | None = None,
    findings: Findings,
    observe: Callable[[Any, Any, Any], None] | None = None,
) -> TypedModel:
    """Resolve every name, infer every shape, and lay out the tables of a model.

    Parameters
    ----------
    file : the model as parsed
    load : returns the file that an ``import`` names; without it imports are an error
    root : name of the root to compile if the model has several
    findings : collects errors and warnings
    observe : is called with each expression, its binding, and its unit if it is a value

    Raises
    ------
    AraelError
        With all errors. Warnings are in `findings`.
    """
    report = Reporter(findings, observe)
    declarations = gather(file, load, report)
    constants = Constants(declarations, report)
    check_functions(declarations, report)
    constants.check_all()
    functions = type_functions(constants, report)
    declare(declarations, constants, report)
    check_containment(declarations, report)
    chosen = choose_root(file, declarations, root, report)
    if chosen is None or _endless(findings):
        report.stop()
    assert chosen is not None

    sites = Sites(declarations, chosen, report)
    if sites.full:
        report.stop()
    paths = Paths(sites, report)
    check_refs(sites, paths)
    blocks = {place: named_blocks(place, paths, report) for place in sites.places()}
    components = {
        place: Components(paths, constants, report).of(place)
        for place in sites.places()
        if not place.struct.component
    }
    constraints = _constraints(sites, paths, constants, blocks, report)
    marginalized = check_marginalize(sites, paths, report)
    passes = Passes(sites, paths, constants, report).all()
    report.stop()

    warn_unused_structs(declarations, report)
    warn_unread_parameters(sites, constraints, report)
    warn_lost_derivatives(sites, components, constraints, report)
    warn_unwrapped_angles(sites, constraints, report)
    report.in_order()
    tables = build_tables(sites, paths)
    entities = build_entities(sites, tables, components)
    return TypedModel(
        name=PurePath(file.source.name).stem,
        root=chosen.name,
        precision=chosen.node.precision or "f64",
        tables=tables,
        entities=entities,
        constraints=tuple(constraints),
        passes=passes,
        blocks=build_blocks(sites, entities, blocks),
        functions=functions,
        constants=tuple((n, source_text(c.value)) for n, c in declarations.consts.items()),
        marginalize=marginalized,
        doc=chosen.node.doc,
    )


def declare(declarations: Declarations, constants: Constants, report: Reporter) -> None:
    """Resolve the members of all structs."""
    fields = Fields(declarations, constants, report)
    for struct in declarations.structs.values():
        sort_members(struct, report)
        declare_fields(fields, struct)
        apply_fixed(struct, report)
        check_keys(struct, report)
    check_members(declarations, report)
    for struct in declarations.structs.values():
        check_blocks(struct, declarations, report)


def _endless(findings: Findings) -> bool:
    """Whether the places of the model could not be laid out."""
    return any(e.code in ("E0401", "E0402") for e in findings.errors)


def _constraints(
    sites: Sites, paths: Paths, constants: Constants, blocks: Blocks, report: Reporter
) -> list[ConstraintSite]:
    """Every constraint at every place of its struct, then the fits of the root."""
    bodies = Bodies(paths, constants, report)
    into = IntoRule(sites, paths, blocks, report)
    found: list[ConstraintSite | None] = []
    for place in sites.places():
        for node in place.struct.constraints:
            found.append(into.check(place, node, bodies.constraint(place, node)))
        for name, prior in place.struct.priors:
            found.append(bodies.prior(place, prior, name))
    root = sites.root.place
    taken = {c.name.id for c in root.struct.constraints} | {n for n, _ in root.struct.priors}
    names = fit_names(root.struct.fits, taken)
    for fit, name in zip(root.struct.fits, names, strict=True):
        found.append(bodies.fit(root, fit, name))
    return [site for site in found if site is not None]

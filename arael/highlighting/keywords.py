"""The words of the language: how each is written, on one line.

`tests/highlighting` compares the list with the grammar.
"""

from __future__ import annotations

ITEMS = {
    "import": 'import "FILE.arael"',
    "const": "const NAME = VALUE",
    "fn": "fn NAME(ARGUMENTS) = FORMULA",
    "extern": "extern fn NAME(ARGUMENTS) derivs [FORMULA, ...]: a function in C",
    "struct": "struct NAME { fields and constraints }",
    "component": "component NAME { parameters, stored numbers, formulas }",
    "root": "root NAME { the collections of the model }",
}
"""Words that begin an item of a file."""

MEMBERS = {
    "param": "param NAME: TYPE [UNIT] in LOW .. HIGH = DEFAULT; or param NAME = FORMULA",
    "skip": "skip NAME: TYPE: stored, never read",
    "constraint": "constraint NAME when GUARD loss KERNEL { let ...; RESIDUAL }",
    "require": "require NAME when GUARD { let ...; LEFT == RIGHT }; also <=, >=, LOW <= X <= HIGH",
    "prior": "prior NAME ~ normal(MEAN, SIGMA)",
    "fixed": "fixed NAME, NAME.x: parameters that no solve changes",
    "fit": "fit COLLECTION as ELEMENT { RESIDUAL }",
    "key": "key NAME: the field by which data refer to a row",
    "marginalize": "marginalize COLLECTION: eliminated first",
    "skip_self_block": "skip_self_block",
    "symbolic": "symbolic NAME = FORMULA: with derivatives",
    "compute": "compute NAME = FORMULA: stored with each row",
    "update": "update { NAME = FORMULA }: after each step",
    "solve": "solve { pass NAME { ... } }",
}
"""Words that begin a member of a struct."""

CLAUSES = {
    "when": "when GUARD: the constraint acts where this holds",
    "loss": "loss KERNEL(SCALE): a robust loss",
    "into": "into ENTITY.BLOCK: where the Hessian pair is stored",
    "as": "fit COLLECTION as ELEMENT",
    "derivs": "derivs [FORMULA, ...]: partial derivatives of a function",
}
"""Words within a declaration."""

TYPES = {
    "list": "list of STRUCT: a collection",
    "deque": "deque of STRUCT: a collection that grows and shrinks at both ends",
    "arena": "arena of STRUCT: a collection whose rows keep their numbers",
    "of": "list of STRUCT",
    "ref": "ref STRUCT in COLLECTION",
    "in": "ref STRUCT in COLLECTION; in LOW .. HIGH",
    "block": "block ENTITY, or block (A, B): a named part of the Hessian",
    "triplets": "triplets: pairs of entities without a named block",
}
"""Words of types."""

PASSES = {
    "pass": "pass NAME { SETTING = VALUE; freeze ...; free ... }",
    "freeze": "freeze COLLECTION.PARAMETER: held in this pass",
    "free": "free COLLECTION.PARAMETER: solved for again",
}
"""Words of a solve schedule."""

FORMULAS = {
    "let": "let NAME = FORMULA",
    "if": "if CONDITION then A else B",
    "then": "if CONDITION then A else B",
    "else": "if CONDITION then A else B",
    "and": "A and B",
    "or": "A or B",
    "not": "not A",
    "true": "true",
    "false": "false",
    "self": "self: this row",
    "parent": "parent: the row that contains this one",
    "root": "root: the model",
}
"""Words of formulas."""

KEYWORDS = {**FORMULAS, **PASSES, **TYPES, **CLAUSES, **MEMBERS, **ITEMS}
"""Every word of the grammar, with how it is written."""

NAMES = frozenset(
    {"list", "deque", "arena", "block", "triplets", "key", "loss", "into", "fit", "pass", "prior"}
    | {"fixed", "solve", "marginalize", "skip", "skip_self_block", "freeze", "free", "symbolic"}
    | {"compute", "update", "derivs", "require"}
)
"""Words that are names everywhere but at their own place."""

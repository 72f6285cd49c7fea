"""What is known to be zero or one in a Jacobian costs nothing in J'J and J'r."""

from collections import Counter

import pytest

from arael.compiler import compiler
from arael.compiler.groups import Kernel
from arael.diagnostics.records import Findings, Source
from arael.syntax.parser import parse
from tests.compiler.test_emit import emitted

POSES = """
struct Pose {
    param p: vec3
    param q: vec3
    z: vec3
    constraint c { BODY }
}
root World { poses: list of Pose }
"""
EDGES = """
struct Pose { param p: vec3; param q: vec3 }
struct Edge {
    a: ref Pose in root.poses
    b: ref Pose in root.poses
    z: vec3
    constraint c { BODY }
}
root World { poses: list of Pose; edges: list of Edge }
"""


def kernel(text: str, body: str) -> Kernel:
    """The kernel of the model's only constraint."""
    source = Source("world.arael", text.replace("BODY", body))
    model = compiler.types(parse(source), Findings())
    (found,) = compiler.derive(model, "world.arael").kernels
    return found


def of_products(found: Kernel) -> Counter[str]:
    """Operations that J'J takes beyond those of residuals and Jacobian."""
    jacobian, whole = found.group.tape, found.linearise
    first = found.group.residuals + len(found.group.jacobian) + len(found.gradient)
    gradient = whole.outputs[:first]
    needed = set()
    stack = list(gradient)
    while stack:
        node = stack.pop()
        if node not in needed and whole.ops[node] not in ("input", "const"):
            needed.add(node)
            stack += whole.args[node]
    assert len(jacobian.outputs) < len(whole.outputs)
    return Counter(
        op
        for node, op in enumerate(whole.ops)
        if op not in ("input", "const") and node not in needed
    )


@pytest.mark.parametrize(
    ("body", "pairs", "operations"),
    [
        # Identity: the products are ones.
        ("p - z", 3, {}),
        # Diagonal: one square each.
        ("[sin(p.x), sin(p.y), sin(p.z)]", 3, {"mul": 3}),
        # A column that is zero has no row and no column.
        ("[sin(p.x) * p.y, q.z]", 4, {"mul": 3}),
        # Two blocks that share no residual.
        ("[sin(p.x) * p.y, sin(q.x) * q.y]", 6, {"mul": 6}),
        # A constant factor is known too.
        ("[2 * p.x, 3 * q.y]", 2, {}),
    ],
)
def test_operations_of_the_products(body: str, pairs: int, operations: dict[str, int]) -> None:
    found = kernel(POSES, body)
    assert len(found.products) == pairs
    assert of_products(found) == operations


def test_a_difference_shares_its_products() -> None:
    """J of b is minus that of a: three blocks of one and the same six products."""
    found = kernel(EDGES, "[sin(b.p.x - a.p.x) * (b.p.y - a.p.y), cos(b.p.z - a.p.z)]")
    assert of_products(found) == {"mul": 4, "neg": of_products(found)["neg"]}


def test_what_is_zero_has_no_code() -> None:
    """One of six scalars is solved for in the constraint: one entry of J'r and of J'J is added."""
    text = emitted(POSES.replace("BODY", "[exp(q.y)]"))
    block = text[text.index("cdef arael_inlined evaluate_0") : text.index("cdef double cost_0")]
    added = [line for line in block.splitlines() if "+=" in line and line.strip()[0] == "h"]
    assert [line.split("[")[1].split("]")[0] for line in added if "_at" not in line] == ["4", "28"]


def test_stored_jacobians_hold_what_is_not_zero(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.compiler.products.UNROLLED_PRODUCTS", 0)
    text = emitted(POSES.replace("BODY", "[sin(p.x) * p.y, q.z, cos(p.x)]"))
    # Runs of a use's neighbouring scalars, by residual: use, first scalar, first entry, entries.
    assert "runs_0[][4] = {{0, 0, 0, 2}, {0, 5, 2, 1}, {0, 0, 3, 1}};" in text
    assert "ends_0[] = {0, 1, 2, 3};" in text
    assert "cdef real jacobian[4 * W]" in text

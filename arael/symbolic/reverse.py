"""Reverse mode over a graph: the derivatives of one scalar by many inputs, as further nodes.

The program of the gradient takes a small multiple of the operations of the formula, however many
inputs there are (A. Griewank and A. Walther, "Evaluating derivatives", 2008, section 3.3). The
derivatives of single operations are SymPy's (`arael.symbolic.derivatives.partials`), each written
as a short program once; no formula is given to SymPy as a whole, so that long ones take no longer
for each operation than short ones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

from arael.runtime.machine.tape import NATIVE, Tape
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.varying import arguments, branches, varying


def read_tape(
    graph: Graph,
    tape: Tape,
    inputs: Sequence[int],
    natives: Mapping[str, Prescribed] | None = None,
) -> list[int]:
    """Nodes of the outputs of a tape for given nodes as its inputs.

    Parameters
    ----------
    natives : the native functions that it calls, by name
    """
    nodes: list[int] = []
    for name, args in zip(tape.ops, tape.args, strict=True):
        if name == "input":
            nodes.append(inputs[args[0]])
        elif name == "const":
            nodes.append(graph.const(tape.constants[args[0]]))
        elif name.startswith(NATIVE):
            function = (natives or {})[name.removeprefix(NATIVE)]
            nodes.append(graph.call(function, [nodes[a] for a in args]))
        else:
            nodes.append(graph.op(name, *(nodes[a] for a in args)))
    return [nodes[k] for k in tape.outputs]


def gradient(graph: Graph, output: int, by: Sequence[int]) -> list[int]:
    """Derivatives of `output` by the nodes `by`, usually inputs, as nodes of the graph.

    What is behind a branch that is not taken has no influence, even where its derivative is not
    finite: where the derivative by a value behind a branch is zero, so is what is passed on.
    """
    seeds = dict.fromkeys(by)
    zero = graph.const(0.0)
    order = varying(graph, [output], seeds)
    reaching = graph.depends([node for node in by if node < len(graph)])
    found: dict[int, int] = {output: graph.const(1.0)}
    switched: set[int] = set()

    def add(node: int, term: int) -> None:
        found[node] = graph.op("add", found[node], term) if node in found else term

    for node in reversed(order):
        value = found.get(node, zero)
        if node in seeds or node not in reaching or value == zero:
            continue
        branch = branches(graph, node)
        if branch is not None:
            condition, taken, otherwise = branch
            for arm, term in (
                (taken, graph.op("select", condition, value, zero)),
                (otherwise, graph.op("select", condition, zero, value)),
            ):
                if arm in reaching:
                    add(arm, term)
                    switched.add(arm)
            continue
        for operand, slope in _slopes(graph, node):
            if operand not in reaching:
                continue
            term = graph.op("mul", value, slope)
            if node in switched:
                switched.add(operand)
                if graph.value(slope) is None:
                    off = graph.op("eq", value, zero)
                    term = graph.op("select", off, zero, term)
            add(operand, term)
    return [found.get(node, zero) for node in by]


def _slopes(graph: Graph, node: int) -> list[tuple[int, int]]:
    """Pairs of an operand and the derivative of `node` by it."""
    name = graph.ops[node]
    operands = arguments(graph, node)
    if not operands:
        return []
    if name in graph.functions:
        function = graph.functions[name]
        if function.partials is not None:
            return list(zip(operands, function.partials(graph, operands), strict=True))
        name = function.name
    numbers, tape = _program(name, len(operands))
    slopes = read_tape(graph, tape, [*operands, node])
    return [(operands[k], slope) for k, slope in zip(numbers, slopes, strict=True)]


@cache
def _program(name: str, count: int) -> tuple[tuple[int, ...], Tape]:
    """Operands that an operation varies with, and the program of its derivatives by them.

    Inputs are the operands, then the value of the operation.
    """
    # imported here: start-up time, since these import SymPy
    from arael.symbolic.derivatives import CONSTANTS, FORMAL, VALUE, partials
    from arael.symbolic.sharing import Writer

    graph = Graph()
    inputs = [graph.input(k) for k in range(count + 1)]
    known = dict(zip((*FORMAL[:count], VALUE), inputs, strict=True))
    known |= {symbol: graph.const(value) for symbol, value in CONSTANTS.items()}
    slopes = partials(name, count)
    writer = Writer(graph, {}, known)
    nodes = [writer.node(slope) for _, slope in slopes]
    return tuple(k for k, _ in slopes), graph.tape(nodes, inputs=range(count + 1))

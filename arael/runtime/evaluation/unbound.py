"""Native functions that a model calls and that nothing is bound to."""

from __future__ import annotations

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Function, Layout
from arael.runtime.machine.compiled import NativeTable


def require_bound(layout: Layout, natives: NativeTable) -> None:
    """Raise AraelError (E0820) for unbound native functions that constraints call."""
    missing = [f for f in layout.functions if f.native and f.name not in natives.bindings]
    if not missing:
        return
    called: dict[str, str] = {}
    for group in layout.groups:
        for tape in (group.tape, group.prepare, group.guard, group.moving_guard, group.arguments):
            for name in sorted(tape.natives if tape is not None else ()):
                called.setdefault(name, group.label)
    wrong = [unbound(f, layout, called[f.name]) for f in missing if f.name in called]
    if wrong:
        raise AraelError(wrong)


def unbound(function: Function, layout: Layout, caller: str = "", way: str = "") -> Diagnostic:
    """Tell that nothing is bound to a native function; `way` is how to do so, if not at loading."""
    return Diagnostic(
        "E0820",
        f"nothing is bound to the native function `{function.name}`",
        origin=function.where,
        notes=(
            *((f"`{caller}` calls it",) if caller else ()),
            "the program that loads the model binds native code; the command line does not",
        ),
        help=(
            f"give it: `{way}`"
            if way
            else f'give it when loading: `arael.load("{layout.source}", '
            f'functions={{"{function.name}": ...}})`',
        ),
    )

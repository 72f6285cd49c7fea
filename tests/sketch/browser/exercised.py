"""Which parts of the page a test exercises: declared by a decorator, checked by what the page does.

A part is named by its kind and id: `tool:split`, `action:undo`, `key:Ctrl+Z`, `snap:grid`,
`panel:history`, `export:dxf`, `import:svg`, `pointer:Wheel`; `key:*` stands for all keys.
`tests/page/test_coverage.py` makes a table of all parts and their tests. A test that declares a
part fails if the page has not run it; what the pointer does is declared only.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

Test = TypeVar("Test", bound=Callable[..., Any])

UNRECORDED = ("pointer",)
"""Kinds that the page does not record."""


def exercises(*parts: str) -> Callable[[Test], Test]:
    """Declare what a test exercises.

    Parameters
    ----------
    parts : each `kind:id`; of a test with parameters all of its parameters together
    """

    def declared(test: Test) -> Test:
        test.exercised = (*getattr(test, "exercised", ()), *parts)  # type: ignore[attr-defined]
        return test

    return declared


RECORDER = """
(() => {
    const seen = (window.exercised = new Set());
    const around = (object, name, note) => {
        const before = object[name].bind(object);
        object[name] = (...given) => {
            const found = before(...given);
            note(found, ...given);
            return found;
        };
    };
    const record = (app) => {
        // a tool is exercised once a command of it was accepted
        const accepted = (reply, part) =>
            Promise.resolve(reply).then(({ ok }) => ok && seen.add(part), () => {});
        around(app.wire, "run", (reply) => accepted(reply, `tool:${app.tools.id}`));
        around(app.wire, "ask", (reply, what) =>
            what === "measure" && accepted(reply, "tool:measure"));
        around(app.store, "select", () => seen.add(`tool:${app.tools.id}`));
        around(app.actions, "run", (_, id) => seen.add(`action:${id}`));
        around(app.actions.byKey, "get", (found, name) => found && seen.add(`key:${name}`));
        around(app.snapper, "place", (place) => place.snap && seen.add(`snap:${place.snap.kind}`));
        around(app.panels, "show", (_, id) => seen.add(`panel:${id}`));
        around(app.wire, "file",
            (reply, { do: word, format }) => accepted(reply, `${word}:${format}`));
    };
    let app;
    Object.defineProperty(window, "app", {
        configurable: true,
        get: () => app,
        set: (made) => { app = made; record(made); },
    });
})();
"""
"""Runs before the page's own modules: notes in `window.exercised` what the page does."""

RECORDED = """async () => {
    const { app, exercised } = window;
    const late = new Promise((done) => setTimeout(done, 1000));
    // answers come in the order of questions: after this one those to earlier commands are here
    if (app?.wire.state === "open") await Promise.race([late, app.wire.ask("history")]);
    return [...(exercised ?? [])];
}"""
"""What a page has done since it was loaded."""

"""The table of mistakes of syntax: every one can be reached."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from arael.diagnostics import explain
from arael.diagnostics.records import AraelError, Source
from arael.syntax import mistakes
from arael.syntax.parser import parse
from arael.syntax.trouble import Trouble

# A text for mistakes that the files in `messages` and the pages of the codes do not show.
FURTHER = [
    ("struct 3 { }", "the struct needs a name"),
    ("root R {\n    gain\n    x: real\n}", "field `gain` has no type"),
    ("struct Pose { loss\n pos: vec3 }", "field `loss` has no type"),
    ("root R { param x: real; constraint c { let y = x = 2; y } }", "a second `=` in one"),
    ("constraint { x }", "`constraint` outside of a struct"),
    ("root R { param x: real; constraint c whem x > 1 { x } }", "unknown word `whem`"),
    ("root R { param x: real; constraint c\n}", "this constraint has no braces"),
    ("struct A with { x: real }", "expected `{` after the header of this struct"),
    (
        "root R { param x: real; constraint c { let real y = x; y } }",
        "`real` does not belong in a `let`",
    ),
    ("root R { param x: real; constraint c { let y == x; y } }", "`=` is missing in this `let`"),
    ("root R { param x: real; constraint c { x[0] = 1 } }", "a value gets its name with `let`"),
    ("root R { param x: real; require c { x = 1 } }", "a comparison is written `==`"),
    ("root R { param x: vec2; require c { x.y = 1 } }", "a comparison is written `==`"),
    ("root R { param x: real; constraint c { double y = x; y } }", "a value gets its name"),
    ("root R {\nparam x: real\nconstraint c {\nlet y\ny } }", "`=` is missing in this `let`"),
]


@pytest.mark.parametrize(("text", "message"), FURTHER)
def test_mistakes(text: str, message: str) -> None:
    with pytest.raises(AraelError) as caught:
        parse(Source("m", text))
    assert message in caught.value.diagnostics[0].message


def test_every_mistake_is_reached_by_a_text_of_these_tests(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    reached: set[str] = set()

    def noting(mistake: Callable[[Trouble], bool]) -> Callable[[Trouble], bool]:
        def noted(t: Trouble) -> bool:
            matches = mistake(t)
            if matches:
                reached.add(mistake.__name__)
            return matches

        return noted

    names = {mistake.__name__ for mistake in mistakes.MISTAKES}
    monkeypatch.setattr(mistakes, "MISTAKES", tuple(map(noting, mistakes.MISTAKES)))
    pages = (Path(explain.__file__).parent / "pages").glob("*.md")
    shown = [*(Path(__file__).parent / "messages").glob("*.md"), *pages]
    texts = [text for text, _ in FURTHER]
    for path in shown:
        texts += re.findall(r"```\w*\n(.*?)```", path.read_text(encoding="utf-8"), re.DOTALL)
    for text in texts:
        with contextlib.suppress(AraelError):
            parse(Source("m", text))
    assert names - reached == set()

"""Phrases that documents, docstrings, comments and messages do not use.

The glossary has the terms. Each pattern is a personification, a riddle or project slang for which a
standard term exists; words with an ordinary technical use are not listed.
"""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]

BANNED = {
    r"who(m|so)?ever": "the thread, the caller, the first writer",
    r"nobody|somebody|anybody|everybody": "no user, the caller, a terminal",
    r"of its own accord": "automatically",
    r"let(s|ting)? go of": "frees, removes",
    r"lends? the session": "yields the session",
    r"who acts|who comes first|who is to blame|who is first": "active instances, first writer",
    r"is (arael's|its) business|arael's business": "arael does it",
    r"ways? (in|out):|way (in|out)\*\*|its way (in|out)": "entry points, results",
    r"(this|other|later|each|language|symbolic|open|its|of|the|pure-Python) rooms?": "package",
    r"rooms? (for|of|that|behind|has|knows?|have)|make room|leave room": "workspace, space",
    r"in the house's|house rules|rules of the house": "common style, rules",
    r"in the manner of": "in the style of, like",
    r"strayed": "left, differs",
    r"promises? to lower|a full step promises": "predicted decrease",
    r"complain(s|ed|ing)?|after a complaint|complaint about": "report, error",
    r"from strangers|from a stranger|strangers": "untrusted",
    r"out of the ordinary|lest|to speak of": "plain words",
    r"dearest|dearer": "more expensive",
    r"brothers": "siblings",
    r"(is|are|be|may|kernels) spoil(t|s)?": "overwritten",
    r"to mend|mended|the mending": "correct, correction, repair",
    r"hears? arael|arael hears": "receives messages",
    r"people think in|people get wrong": "representations, mistakes",
    r"what stands in the way": "reasons",
}
"""Pattern -> what to write instead."""

KINDS = {".py", ".pyx", ".pxd", ".pxi", ".pyi", ".h", ".md", ".toml", ".cfg", ".arael"}
FOLDERS = ("arael", "docs", "examples", "models", "grammar", "tests")


def sources() -> list[Path]:
    """Sources of the project, without generated files and this one."""
    found = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*") if p.suffix in KINDS]
    found += [ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    return sorted(p for p in found if p.name != Path(__file__).name and "build" not in p.parts)


SPACES = r"\s+(?:#:?\s+|\*\s+)?"
ANY = re.compile("|".join(BANNED).lower().replace(" ", SPACES))
"""What lower-case text with a banned phrase has somewhere: searched five times as fast."""


def phrases(text: str) -> list[str]:
    """Banned phrases of `text`, each with its line; comment signs and line breaks are skipped."""
    found: list[str] = []
    if not ANY.search(text.lower()):
        return found
    for pattern, better in BANNED.items():
        spaced = pattern.replace(" ", SPACES)
        for match in re.finditer(rf"(?<![\w-])(?:{spaced})(?![\w-])", text, re.IGNORECASE):
            line = text.count("\n", 0, match.start()) + 1
            found.append(f"{line}: {' '.join(match[0].split())!r}, better: {better}")
    return found


def test_sources_use_standard_terms() -> None:
    found = {
        str(path.relative_to(ROOT)): bad
        for path in sources()
        if (bad := phrases(path.read_text(encoding="utf-8")))
    }
    assert found == {}


def test_a_phrase_over_two_lines_is_found() -> None:
    assert phrases("    # which lets go\n    # of its rows") == [
        "1: 'lets go # of', better: frees, removes"
    ]


def test_terms_of_the_glossary_are_linked() -> None:
    for page in ("docs/index.md", "CONTRIBUTING.md", "README.md"):
        assert "glossary.md" in (ROOT / page).read_text(encoding="utf-8"), page

"""Many motions in few sentences: those that differ by names only are one."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from arael.sketch.judge.motions import Motion, listed, shortened

MOST = 6
"""So many motions, and so many groups of more motions, are listed."""

_NAMES = re.compile(r"\b(?!p[12]\b)[A-Za-z]+\d+(?:\.\.[A-Za-z]+\d+)?(?:\.\w+)?")
_POINT = re.compile(r"□\.?|\([^)]*\)")
_POLE = re.compile(r"pole \d+ of")


@dataclass(frozen=True, slots=True)
class Alike:
    """Motions that are alike.

    Attributes
    ----------
    sentence : ``L0..L9 can each slide along themselves``
    entities : names of what moves
    count : degrees of freedom
    """

    sentence: str
    entities: tuple[str, ...]
    count: int


def alike(motions: Sequence[Motion]) -> list[Alike]:
    """Motions of the same words as one; a few motions as they are.

    Groups are in the order of their first motion.
    """
    if len(motions) <= MOST:
        return [Alike(one.sentence, one.entities, 1) for one in motions]
    groups: dict[str, list[Motion]] = {}
    for one in motions:
        groups.setdefault(_words(one.sentence), []).append(one)
    return [_together(words, members) for words, members in groups.items()]


def _words(sentence: str) -> str:
    """A sentence without its names; as it is if it is about several things."""
    if sentence.count(" can ") != 1:
        return sentence
    subject, deed = sentence.split(" can ")
    subject = _POLE.sub("the poles of", _NAMES.sub("□", subject))
    if subject.startswith("□"):  # one entity, or several as one body
        subject = "□"
    deed = _POINT.sub("a point", _NAMES.sub("□", deed))
    return f"{subject} can {deed}"


def _together(words: str, members: Sequence[Motion]) -> Alike:
    entities = tuple(dict.fromkeys(name for one in members for name in one.entities))
    first = members[0].sentence
    if len(members) == 1 or first == words:
        return Alike(first, entities, len(members))
    subjects = list(dict.fromkeys(_subject(one.sentence) for one in members))
    subject, _, deed = words.partition(" can ")
    if len(subjects) == 1:  # one thing about several points
        return Alike(f"{subject.replace('□', subjects[0])} can {deed}", entities, len(members))
    deed = deed.replace("itself", "themselves")
    said = listed(shortened(subjects))
    return Alike(f"{subject.replace('□', said)} can each {deed}", entities, len(members))


def _subject(sentence: str) -> str:
    """Names before the verb; those of a body in brackets."""
    subject = sentence.partition(" can ")[0]
    names = _NAMES.findall(subject)
    return names[0] if len(names) == 1 and ".." not in subject else f"({subject})"

"""Did you mean ...? Names close to a misspelt one."""

from __future__ import annotations

from collections.abc import Iterable

_MAX_LENGTH = 100


def closest(name: object, candidates: Iterable[str], limit: int = 1) -> list[str]:
    """Candidates that `name` may be a misspelling of, best first, at most `limit`.

    A candidate that differs in case or underscores only comes first; the others by the number of
    edits (a letter added, removed, changed, or swapped with its neighbour), at most one in three
    letters. Ties are in the order of `candidates`. Nothing is close to what is not a text.
    """
    if not isinstance(name, str) or not name or len(name) > _MAX_LENGTH:
        return []
    folded = _fold(name)
    allowed = max(1, (len(folded) + 1) // 3)
    ranked: list[tuple[int, int, str]] = []
    for order, candidate in enumerate(dict.fromkeys(candidates)):
        other = _fold(candidate)
        if candidate == name or abs(len(other) - len(folded)) > allowed:
            continue
        distance = 0 if other == folded else _edits(folded, other, allowed)
        if distance <= allowed and (distance < len(folded) or distance == 0):
            ranked.append((distance, order, candidate))
    return [candidate for _, _, candidate in sorted(ranked)[:limit]]


def _fold(name: str) -> str:
    return name.replace("_", "").replace("-", "").lower() or name


def _edits(a: str, b: str, limit: int) -> int:
    """Restricted Damerau-Levenshtein distance of `a` and `b`; ``limit + 1`` if it is larger."""
    before: list[int] = []
    previous = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        current = [i]
        for j, y in enumerate(b, 1):
            cost = min(previous[j] + 1, current[-1] + 1, previous[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, before[j - 2] + 1)
            current.append(cost)
        if min(current) > limit:
            return limit + 1
        before, previous = previous, current
    return previous[-1]

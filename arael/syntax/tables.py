"""LALR(1) tables of the grammar, made by Lark once and kept as JSON beside it.

Lark needs some 200 ms to turn ``arael.lark`` into tables; reading them back takes about 5 ms. The
file records a hash of the grammar it was made from, so that a checkout with an edited grammar makes
new tables in memory instead of using stale ones. ``python -m arael.syntax.tables`` writes the file
anew.
"""

from __future__ import annotations

import hashlib
import json
from collections import deque
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

STARTS = ("start", "expression", "loss_alone")
END = "$END"


@dataclass(frozen=True)
class Production:
    """One alternative of a rule.

    `template` says what becomes of the symbols of the right-hand side: ``(i, False)`` keeps the
    i-th, ``(i, True)`` splices the list there, ``(-1, False)`` is an optional part left out.
    """

    name: str
    handler: str
    size: int
    template: tuple[tuple[int, bool], ...]
    passes_through: bool


@dataclass(frozen=True)
class Tables:
    """What the lexer and the parser need to know of the grammar.

    An entry of `rows` maps a terminal to ``state + 1`` (shift) or ``-production - 1`` (reduce); an
    entry of `gotos` maps a production's name to the state that follows it.
    """

    words: dict[str, str]
    symbols: dict[str, str]
    patterns: dict[str, str]
    ignored: tuple[str, ...]
    productions: tuple[Production, ...]
    rows: tuple[dict[str, int], ...]
    gotos: tuple[dict[str, int], ...]
    start_states: dict[str, int]
    end_states: dict[str, int]

    def spelling(self, terminal: str) -> str | None:
        """How `terminal` is written where there is one way only."""
        return self._spellings.get(terminal)

    @property
    def _spellings(self) -> dict[str, str]:
        return {name: text for text, name in (*self.words.items(), *self.symbols.items())}


def grammar_folder() -> Path:
    """Folder of the grammar: ``arael/grammar`` when installed, ``grammar`` in a checkout."""
    package = Path(__file__).resolve().parent.parent
    installed = package / "grammar"
    return installed if (installed / "arael.lark").is_file() else package.parent / "grammar"


def grammar_text() -> str:
    """Return the grammar as Lark reads it."""
    return (grammar_folder() / "arael.lark").read_text(encoding="utf-8").replace("\r\n", "\n")


@cache
def load() -> Tables:
    """Tables of the grammar: from the file beside it, or made anew where that is stale."""
    text = grammar_text()
    try:
        data = json.loads((grammar_folder() / "arael.tables.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        data = None
    if data is None or data.get("grammar") != _digest(text):
        data = generate(text)
    return _decode(data)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _decode(data: dict[str, Any]) -> Tables:
    names: list[str] = data["names"]
    rows = [{names[k]: v for k, v in zip(r[::2], r[1::2], strict=True)} for r in data["rows"]]
    gotos = [{names[k]: v for k, v in zip(r[::2], r[1::2], strict=True)} for r in data["gotos"]]
    return Tables(
        words=data["words"],
        symbols=data["symbols"],
        patterns=data["patterns"],
        ignored=tuple(data["ignored"]),
        productions=tuple(
            Production(names[n], names[h], size, tuple((i, bool(s)) for i, s in template), bool(p))
            for n, h, size, template, p in data["productions"]
        ),
        rows=tuple(rows[i] for i in data["row_of_state"]),
        gotos=tuple(gotos[i] for i in data["goto_of_state"]),
        start_states=data["start_states"],
        end_states=data["end_states"],
    )


def generate(text: str) -> dict[str, Any]:
    """JSON form of the tables of grammar `text`; the same text gives the same tables."""
    from lark import Lark
    from lark.lexer import PatternStr
    from lark.parsers.lalr_analysis import Shift

    # Lark has no public way to hand out its tables; these attributes are what its own stand-alone
    # generator reads.
    lark = Lark(text, parser="lalr", lexer="basic", start=list(STARTS), maybe_placeholders=True)
    table = lark.parser.parser._parse_table
    numbers = _number_states(table, Shift)
    rules = {rule: i for i, rule in enumerate(lark.rules)}
    names: dict[str, int] = {}

    def name(text: str) -> int:
        return names.setdefault(text, len(names))

    rows: dict[tuple[int, ...], int] = {}
    gotos: dict[tuple[int, ...], int] = {}
    row_of_state, goto_of_state = [], []
    terminals = {t.name for t in lark.terminals} | {END}
    for state in numbers:
        row: list[int] = []
        goto: list[int] = []
        for symbol, (action, target) in sorted(table.states[state].items()):
            if symbol not in terminals:
                goto += [name(symbol), numbers[target]]
            elif action is Shift:
                row += [name(symbol), numbers[target] + 1]
            else:
                row += [name(symbol), -rules[target] - 1]
        row_of_state.append(rows.setdefault(tuple(row), len(rows)))
        goto_of_state.append(gotos.setdefault(tuple(goto), len(gotos)))

    productions = []
    for rule in lark.rules:
        template = _template(rule)
        helper = rule.origin.name.startswith("_")
        one = len(template) == 1 and template[0][0] >= 0 and len(rule.expansion) == 1
        passes = one and ((rule.options.expand1 and not rule.alias) or (helper and template[0][1]))
        handler = "" if helper else rule.alias or rule.origin.name
        productions.append(
            [name(rule.origin.name), name(handler), len(rule.expansion), template, int(passes)]
        )

    words, symbols, patterns = {}, {}, {}
    for t in sorted(lark.terminals, key=lambda t: t.name):
        if not isinstance(t.pattern, PatternStr):
            patterns[t.name] = t.pattern.to_regexp()
        elif t.pattern.value.isidentifier():
            words[t.pattern.value] = t.name
        else:
            symbols[t.pattern.value] = t.name
    return {
        "grammar": _digest(text),
        "words": words,
        "symbols": symbols,
        "patterns": patterns,
        "ignored": sorted(lark.ignore_tokens),
        "names": list(names),
        "productions": productions,
        "rows": [list(r) for r in rows],
        "gotos": [list(g) for g in gotos],
        "row_of_state": row_of_state,
        "goto_of_state": goto_of_state,
        "start_states": {s: numbers[table.start_states[s]] for s in STARTS},
        "end_states": {s: numbers[table.end_states[s]] for s in STARTS},
    }


def _number_states(table: Any, shift: Any) -> dict[int, int]:
    """Give each state its number in the order of a breadth-first walk, so that runs agree."""
    order: dict[int, int] = {}
    queue = deque(table.start_states[s] for s in STARTS)
    while queue:
        state = queue.popleft()
        if state in order:
            continue
        order[state] = len(order)
        row = table.states[state]
        queue.extend(target for _, (action, target) in sorted(row.items()) if action is shift)
    return order


def _template(rule: Any) -> list[tuple[int, int]]:
    """Work out what a production keeps, as Lark's own tree builder would."""
    empties = list(rule.options.empty_indices) or [False] * len(rule.expansion)
    template: list[tuple[int, int]] = []
    position = 0
    for empty in empties:
        if empty:
            template.append((-1, 0))
            continue
        symbol = rule.expansion[position]
        if not symbol.is_term:
            template.append((position, int(symbol.name.startswith("_"))))
        elif rule.options.keep_all_tokens or not symbol.filter_out:
            template.append((position, 0))
        position += 1
    return template


def main() -> None:
    """Write ``arael.tables.json`` beside the grammar."""
    parts = generate(grammar_text())
    lines = [f"{json.dumps(key)}: {_compact(value)}" for key, value in parts.items()]
    path = grammar_folder() / "arael.tables.json"
    path.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")


def _compact(value: Any) -> str:
    return json.dumps(value, separators=(",", ":"))


if __name__ == "__main__":
    main()

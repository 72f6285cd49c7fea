"""Attributes of the Rust framework, which are comments in arael and would be ignored silently.

``#[arael(constraint(hb, { ... }))]`` may span many lines; it is skipped as a whole, so that the
text after it is parsed correctly, and the diagnostic proposes the equivalent.
"""

from __future__ import annotations

import re

from arael.syntax.log import ErrorLog

_ATTRIBUTE = re.compile(r"#!?\[\s*(?:arael|derive|allow|cfg|inline|test|rustfmt)\b")
_CLOSERS = {"(": ")", "[": "]", "{": "}"}
_MAX_LENGTH = 20_000
_MAX_SHOWN = 60


def skip_attribute(text: str, at: int, log: ErrorLog) -> int | None:
    """Report the attribute at `at` and return its end; None if it is a comment."""
    if not _ATTRIBUTE.match(text, at):
        return None
    opening = text.index("[", at)
    line_end = text.find("\n", at)
    line_end = len(text) if line_end < 0 else line_end
    end = _end(text, opening) or line_end
    inside = text[opening + 1 : end - 1].strip()
    log.error(
        "E0150",
        "this is a Rust attribute, and a comment in arael",
        at,
        min(end, line_end),
        "has no effect here",
        help=_answer(inside, text[end : end + 300]),
    )
    return end


def _end(text: str, opening: int) -> int | None:
    """End of the brackets that open at `opening`; None if they are not closed."""
    waiting: list[str] = []
    at = opening
    limit = min(len(text), opening + _MAX_LENGTH)
    while at < limit:
        char = text[at]
        if text.startswith("//", at) or text.startswith("/*", at):
            close = text.find("\n" if text[at + 1] == "/" else "*/", at + 2)
            at = limit if close < 0 else close
        elif char == '"':
            close = text.find('"', at + 1)
            at = limit if close < 0 else close
        elif char in _CLOSERS:
            waiting.append(_CLOSERS[char])
        elif char in ")]}":
            if waiting.pop() != char:
                return None
            if not waiting:
                return at + 1
        at += 1
    return None


def _answer(inside: str, after: str) -> tuple[str, ...]:
    field = re.match(r"\s*(?:pub\s+)?(\w+)\s*:\s*(.*)", after)
    name = field[1] if field else "x"
    struct = re.search(r"\bstruct\s+(\w+)", after)
    if re.match(r"arael\s*::\s*model\b", inside):
        return ("delete it: `struct NAME { ... }` is enough",)
    if re.match(r"arael\s*::\s*function\b", inside):
        return _function(inside, after)
    found = re.match(r"arael\s*\(\s*(\w+)\s*(.*)\)$", inside, re.DOTALL)
    if not found:
        return ("delete it",)
    word, rest = found[1], found[2].lstrip("= \n(")
    if word == "root":
        return _root(found[2], struct[1] if struct else "NAME")
    if word == "constraint":
        return _constraint(rest, struct[1] if struct else "")
    if word == "fit":
        return _fit(rest)
    if word == "ref":
        target = re.search(r"Ref\s*<\s*(\w+)", field[2]) if field else None
        return (f"write `{name}: ref {target[1] if target else 'T'} in {_clip(found[2][1:])}`",)
    if word == "cross":
        pair = re.sub(r"\s+", " ", found[2].lstrip("= ").strip("() "))
        return (f"write `{name}: block ({_clip(pair)})`, or omit the field",)
    if word == "constraint_index":
        return (f"write `{name}: constraint_index`",)
    if word == "skip":
        return (f"write `skip {name}: ...` with a value type, or omit the field",)
    if word == "skip_self_block":
        return ("write `skip_self_block` on a line inside the struct",)
    return (
        "delete it; a model is declared by `struct` and `root`, and constraints are written "
        "`constraint name { ... }` inside the struct",
    )


def _root(flags: str, name: str) -> tuple[str, ...]:
    precision = " : f32" if re.search(r"\bf32\b", flags) else ""
    answers = [f"write `root {name}{precision} {{ ... }}` in place of `struct {name}`"]
    if "jacobian" in flags:
        answers.append("every model has `jacobian()` and `cost_table()`")
    if "extended" in flags:
        answers.append("formulas known at run time only: `arael.runtime_residual` in Python")
    fit = re.search(r"\bfit\s*\((.*)", flags, re.DOTALL)
    return (*answers, *(_fit(fit[1]) if fit else ()))


def _fit(rest: str) -> tuple[str, ...]:
    found = re.match(r"\s*(\w+)\s*,\s*\|\s*(\w+)\s*\|", rest)
    collection, element = (found[1], found[2]) if found else ("data", "e")
    return (f"write `fit {collection} as {element} {{ ... }}` inside the root",)


def _constraint(rest: str, struct: str) -> tuple[str, ...]:
    head = rest.split("{", 1)[0]
    name = re.search(r'\bname\s*=\s*"(\w+)"', head)
    guard = re.search(r"\bguard\s*=\s*([^,]+)", head)
    parent = re.search(r"\bparent\s*=\s*(\w+)", head)
    blocks = re.match(r"[\s(]*(\[[^\]]*\]|[\w.]+(?:\s*,\s*[\w.]+(?=\s*[,}]))*)", head)
    when = ""
    if guard:
        condition = re.sub(r"\.is_some\(\)", "", guard[1].strip())
        condition = re.sub(r"(\S+)\.is_none\(\)", r"not \1", condition)
        when = f" when {_clip(condition.replace('self.', ''))}"
    inside = f"`struct {struct}`" if struct else "the struct"
    answers = [
        f"write `constraint {name[1] if name else 'NAME'}{when} {{ ... }}` inside {inside}, with "
        "the body as it is"
    ]
    if parent:
        answers.append(f"begin the body with `let {parent[1]} = parent`")
    if blocks:
        block = re.sub(r"\s+", " ", blocks[1])
        if "," in block and not block.startswith("["):
            block = f"[{block}]"
        answers.append(
            f"blocks are inferred; write `into {_clip(block)}` after the name to keep it"
        )
    return tuple(answers)


def _function(inside: str, after: str) -> tuple[str, ...]:
    arguments = re.search(r"\bfn\s+(\w+)\s*\(([^)]*)\)", after)
    named = re.match(r"arael\s*::\s*function\s*\(\s*(\w+)\s*,", inside)
    parameters = "x"
    if arguments:
        parameters = ", ".join(p.split(":")[0].strip() for p in arguments[2].split(","))
    name = named[1] if named else arguments[1] if arguments else "f"
    if named:
        return (
            f"write `extern fn {name}({_clip(parameters)}) derivs [...]`, and bind the native code "
            "from Python",
        )
    derivs = " derivs [...]" if "derivs" in inside else ""
    return (f"write `fn {name}({_clip(parameters)}){derivs} = ...`",)


def _clip(text: str) -> str:
    text = re.sub(r"\s+", " ", text.strip())
    return text if len(text) <= _MAX_SHOWN else text[:_MAX_SHOWN] + "..."

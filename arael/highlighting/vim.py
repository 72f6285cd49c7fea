"""The syntax file for Vim and Neovim."""

from __future__ import annotations

from arael.highlighting import words

_HEAD = """\
" Vim syntax file: models of arael. Written by `python -m arael.highlighting`.
if exists("b:current_syntax")
  finish
endif

syn case match
"""

_TAIL = r"""
syn match araelNumber "\<[0-9]\+\(\.[0-9]\+\)\?\([eE][+-]\?[0-9]\+\)\?\>"
syn match araelUnit "\(\<[a-z0-9]\+\(<[0-9, ]*>\)\?\s*\)\@<=\[[A-Za-z0-9_*/^() .-]*\]" contains=NONE
syn region araelString start=+"+ skip=+\\.+ end=+"+ end=+$+
syn match araelComment "#.*$" contains=@Spell
syn match araelStruct "\(\<\(struct\|root\|component\)\s\+\)\@<=\h\w*"
syn match araelName "\(\<\(constraint\|pass\|let\|const\|symbolic\|compute\|fn\)\s\+\)\@<=\h\w*"

hi def link araelKeyword Keyword
hi def link araelBranch Conditional
hi def link araelLogic Operator
hi def link araelValue Boolean
hi def link araelEntity Special
hi def link araelType Type
hi def link araelFunction Function
hi def link araelConstant Constant
hi def link araelNumber Number
hi def link araelUnit SpecialChar
hi def link araelString String
hi def link araelComment Comment
hi def link araelStruct Structure
hi def link araelName Identifier

let b:current_syntax = "arael"
"""


def syntax() -> str:
    """The syntax file."""
    groups = [
        ("araelKeyword", words.RESERVED),
        ("araelBranch", words.BRANCHES),
        ("araelLogic", words.LOGIC),
        ("araelValue", words.VALUES),
        ("araelEntity", tuple(e for e in words.ENTITIES if e != "root")),
        ("araelConstant", words.PREDEFINED),
    ]
    lines = [f"syn keyword {name} {' '.join(sorted(group))}" for name, group in groups]
    names = r"\|".join(words.CONTEXTUAL)
    followed = r"\(\s*[:=.,)\]+*/^-]\)\@!"
    lines.append(rf'syn match araelKeyword "\<\({names}\)\>{followed}"')
    lines.append(rf'syn match araelType "\<\({_alternatives(words.TYPES)}\)\>\(\s*(\)\@!"')
    lines.append(rf'syn match araelFunction "\<\({_alternatives(words.BUILTINS)}\)\>\(\s*(\)\@="')
    return _HEAD + "\n".join(lines) + "\n" + _TAIL


def _alternatives(group: tuple[str, ...]) -> str:
    return r"\|".join(sorted(group))

"""Colours for `.arael` files: a Pygments lexer, and the grammars of editors."""

"""Inputs drawn from a seed, examined in processes whose time and memory are bounded.

``pytest -m slow tests/fuzz --fuzz-seed random --fuzz-seconds 60`` draws new inputs for a minute a
test and prints the seed. A failing input is kept in ``.fuzz-failures`` with a text file that says
what happened and how to examine it again. What a campaign finds becomes a named test where the
defect was; the campaign itself asserts only what holds for any input.
"""

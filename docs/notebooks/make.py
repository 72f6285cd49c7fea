"""Runs the notebooks and keeps their outputs: each ``NAME.py`` here gives ``NAME.ipynb``.

Run ``python docs/notebooks/make.py [NAME ...]`` after a notebook, a model or its data was changed;
it needs ``pip install jupytext nbclient ipykernel``. The ``.py`` files are the sources, with cells
in the percent format of jupytext.
"""

from __future__ import annotations

import sys
from pathlib import Path

import jupytext
import nbclient

HERE = Path(__file__).parent


def make(name: str) -> None:
    """Run one notebook in this folder, and write it with its outputs."""
    notebook = jupytext.read(HERE / f"{name}.py")
    client = nbclient.NotebookClient(
        notebook,
        timeout=300,
        kernel_name="python3",
        record_timing=False,
        resources={"metadata": {"path": str(HERE)}},
    )
    client.execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    for number, cell in enumerate(notebook.cells):
        cell["id"] = f"cell-{number}"  # as jupytext's are drawn at random
    jupytext.write(notebook, HERE / f"{name}.ipynb")


if __name__ == "__main__":
    for chosen in sys.argv[1:] or sorted(p.stem for p in HERE.glob("*.py") if p.stem != "make"):
        make(chosen)
        print(f"wrote {chosen}.ipynb")

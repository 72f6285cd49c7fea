"""Figure of docs/certificate.md: a ring of poses in its global optimum, and in a local one.

Run ``python docs/figures/certificate.py``.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

PAGE = Path(__file__).parents[1] / "certificate.md"


def main() -> None:
    """Draw the poses of the page's two rings, solved."""
    code = re.search(r"```python\n(.*?)\nfor turns", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert code is not None
    names: dict[str, Any] = {}
    exec(code[1], names)
    figure, axes = plt.subplots(1, 2, figsize=(6.4, 3), layout="constrained")
    for turns, axis in enumerate(axes):
        graph = names["ring"](turns)
        result = graph.solve()
        t, th = np.asarray(graph.poses.t.value), np.asarray(graph.poses.th.value)
        closed = np.vstack([t, t[:1]])
        axis.plot(closed[:, 0], closed[:, 1], color="0.7")
        axis.quiver(t[:, 0], t[:, 1], np.cos(th), np.sin(th), color="C0", width=0.012)
        verdict = "global" if result.certificate.certified else "not certified"
        axis.set(title=f"cost {result.end_cost:.3g}: {verdict}", aspect="equal")
        axis.margins(0.25)
    figure.savefig(Path(__file__).with_name("certificate.png"), dpi=110)


if __name__ == "__main__":
    main()

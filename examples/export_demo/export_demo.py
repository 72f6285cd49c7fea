"""A window of three poses and two landmarks, exported as C, for Ceres and for GTSAM.

The generated files beside this script are what it writes; `--output` writes them elsewhere.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import Any

import arael

HERE = Path(__file__).parent


def window() -> Any:
    """A window with measurements of a straight drive past two landmarks, and a poor start."""
    found: Any = arael.load(HERE / "window.arael", interpret=True)()  # type: ignore[call-arg]
    poses = [found.poses.append(pos=[1.1 * k, 0.1 * k], th=0.05 * k) for k in range(3)]
    landmarks = [found.landmarks.append(pos=pos) for pos in ([1.5, 1.5], [2.5, -0.5])]
    for a, b in pairwise(poses):
        found.steps.append(a=a, b=b, moved=[1.0, 0.0], turned=0.0)
    ranges = [[1.414, 1.0, 1.414], [2.236, 1.414, 1.0]]
    bearings = [[0.785, 1.571, 2.356], [-0.464, -0.785, -1.571]]
    for i, landmark in enumerate(landmarks):
        for k, pose in enumerate(poses):
            found.sights.append(
                pose=pose, landmark=landmark, range=ranges[i][k], bearing=bearings[i][k]
            )
    found.anchors.append(pose=poses[0], pos=[0.0, 0.0], th=0.0)
    return found


def exports() -> dict[str, str | bytes]:
    """Text of each generated file by its name."""
    model, data = HERE / "window.arael", window()
    found = dict(arael.export(model, "c", data=data, size="data").files)
    for target in ("ceres", "gtsam"):
        files = arael.export(model, target).files
        found[f"window_{target}.h"] = files[f"window_{target}.h"]
    return found


def main() -> None:
    """Write the files, and print the solution that `main.c` has to find."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=HERE, help="folder of the files")
    folder = parser.parse_args().output
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in exports().items():
        assert isinstance(text, str)
        (folder / name).write_text(text, encoding="utf-8")
        print(f"wrote {folder / name}")
    data = window()
    result = data.solve()
    print(f"cost {result.cost:.6g}, landmarks {data.landmarks.pos.value.round(3).tolist()}")


if __name__ == "__main__":
    main()

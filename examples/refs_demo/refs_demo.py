"""Refs and collections: a sliding window of poses whose handles stay valid.

python refs_demo.py [--plot refs_demo.png]
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import arael

MODEL = Path(__file__).with_name("refs.arael")
SPACING, WINDOW = 1.0, 6


class Drive:
    """A drive along a line with a sliding window."""

    def __init__(self, seed: int = 5) -> None:
        self.rng = np.random.default_rng(seed)
        self.window = arael.load(MODEL)()
        self.truth = [2.0, 5.0, 9.0]
        self.landmarks = [self.window.landmarks.append(x=0.0) for _ in self.truth]
        self.time = 0

    def advance(self) -> Any:
        """Add a pose with its step and observations, remove the oldest; returns the new ref."""
        window, noise = self.window, self.rng.normal
        here = SPACING * self.time
        last = window.poses[-1] if len(window.poses) else None
        pose = window.poses.append(x=here + noise(0, 0.5), prior=here + noise(0, 1.0))
        if last is not None:
            # `from` is a keyword of Python, so it is accessed by name.
            window.steps.append(**{"from": last}, to=pose, length=SPACING + noise(0, 0.05))
        for landmark, x in zip(self.landmarks, self.truth, strict=True):
            if landmark.is_valid and abs(x - here) < 4:
                landmark.sightings.append(pose=pose, distance=x - here + noise(0, 0.1))
        if len(window.poses) > WINDOW:
            self.retire()
        self.time += 1
        return pose

    def retire(self) -> None:
        """Drop the oldest pose and every row that refers to it."""
        window = self.window
        window.poses.popleft()
        stale = ~window.steps["from"].is_valid
        window.steps.remove(window.steps.refs[np.flatnonzero(stale)])
        for landmark in window.landmarks:
            gone = np.flatnonzero(~landmark.sightings.pose.is_valid)
            landmark.sightings.remove(landmark.sightings.refs[gone])


def plot(drive: Drive, path: Path) -> None:
    """Draw the window: poses, landmarks, and refs."""
    from arael.plot.figure import BLUE, GREY, ORANGE, new_figure, save, styled

    @styled
    def drawn() -> Any:
        figure, (axes,) = new_figure(7.2, 3.2)
        window = drive.window
        for landmark in window.landmarks:
            for sighting in landmark.sightings:
                axes.plot([sighting.pose.x.value, landmark.x.value], [0, 1], color=GREY, lw=0.8)
        retired = SPACING * np.arange(drive.time - WINDOW)
        axes.plot(retired, 0 * retired, "o", mfc="none", mec=GREY, label="retired")
        axes.plot(window.poses.x.value, 0 * window.poses.x.value, "o", color=BLUE, label="poses")
        x = window.landmarks.x.value
        axes.plot(x, 0 * x + 1, "^", color=ORANGE, label="landmarks")
        axes.set_yticks([])
        axes.set_ylim(-0.4, 1.6)
        axes.set_xlabel("m")
        axes.legend(loc="upper left", ncols=3)
        return figure

    save(drawn(), path)


def main(arguments: list[str] | None = None) -> None:
    """Drive, and print the state of handles while rows are added and removed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args(arguments)

    drive = Drive()
    window = drive.window
    first = drive.advance()
    kept = drive.advance()
    print(f"{first.name} and {kept.name}, {len(window.poses)} poses")
    while drive.time < 7:
        pose = drive.advance()
    print(f"after {drive.time} steps: {window.poses!r}")
    print(f"the first handle is valid: {first.is_valid}; the second is now {kept.name}")
    try:
        print(first.x.value)
    except arael.AraelError as error:
        print(f"reading through it: {error.diagnostics[0].code}")

    print(f"solved: {window.solve().status}, cost {window.cost():.3f}")
    print(f"refs read through: the last step leads to {window.steps[-1].to.name}, "
          f"which is the newest pose: {window.steps[-1].to == pose}")  # fmt: skip

    window.landmarks.remove(drive.landmarks[0])
    left = [landmark.name for landmark in drive.landmarks if landmark.is_valid]
    print(f"a landmark removed, its sightings with it: left are {', '.join(left)}")
    while drive.time < 10:
        drive.advance()
    result = window.solve()
    print(f"solved: {result.status}, cost {window.cost():.3f}")
    for landmark, truth in zip(drive.landmarks, drive.truth, strict=True):
        if landmark.is_valid:
            print(f"{landmark.name}: {landmark.x.value:.3f} m, truth {truth:.3f} m")
    if args.plot:
        plot(drive, args.plot)


if __name__ == "__main__":
    main()

"""Checks an installed arael as a machine without a compiler would see it.

Run by the expression machine of the environment, from a folder that is not a checkout::

    python .ci/wheel_check.py [--without TEXT ...]

No file of the standard models may contain TEXT (the folder that the wheel was built in).
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

OWN = """\
# A straight line, in a file that no wheel knows.
struct Point { x: real; y: real }

root Own {
    param slope: real = 0
    param offset: real = 0
    points: list of Point

    fit points as p { slope * p.x + offset - p.y }
}
"""
POINTS = {"points": [{"x": float(x), "y": 2.0 * x + 1.0} for x in range(6)]}

STANDARD = """\
import json
from arael.compiler import processor
from arael.loading import load_compiled, standard_models
full = processor.usable_targets()
print(json.dumps({
    "targets": full,
    "origins": {n: [(c := load_compiled(n)).origin, c.folder.name] for n in standard_models()},
}))
"""

SOLVE = """\
import arael
line = arael.load("linear")(sigma=1.0)
line.data.extend(x=[0.0, 1.0, 2.0, 3.0], y=[1.0, 3.0, 5.0, 7.0])
result = line.solve()
assert result.status == "converged", result
assert abs(line.a.value - 2) < 1e-3 and abs(line.b.value - 1) < 1e-3, (line.a, line.b)
"""

# A processor with AVX2 and without AVX-512 takes the kernels made for it.
OLDER = """\
from arael.compiler import processor
from arael.loading import load_compiled
older = frozenset(f for f in processor.flags() if not f.startswith("avx512"))
processor.flags = lambda: older
taken = load_compiled("slam")
assert (taken.origin, taken.folder.name) == ("shipped", "slam-x86-64-v3"), taken
"""


def main() -> None:
    """Run every check; the first that fails ends the program with its reason."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--without", action="append", default=[], metavar="TEXT")
    without = [text.encode() for text in parser.parse_args().without]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        _standard_models_are_compiled()
        _paths_stay_behind(without)
        _own_model_is_interpreted()
        _doctor_is_content()


def _run(*arguments: str, warns: bool = False) -> subprocess.CompletedProcess[str]:
    """Run Python where nothing but this environment is on PATH."""
    keep = ("SYSTEMROOT", "TEMP", "TMP", "TMPDIR", "LD_LIBRARY_PATH")
    env = {name: os.environ[name] for name in keep if name in os.environ}
    env |= {"PATH": str(Path(sys.executable).parent), "PYTHONUTF8": "1"}
    env |= {"HOME": str(Path.cwd()), "ARAEL_CACHE_DIR": str(Path.cwd() / "cache")}
    if not warns:  # interpreting would be a warning
        env["PYTHONWARNINGS"] = "error::UserWarning"
    done = subprocess.run(
        [sys.executable, *arguments], env=env, capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise SystemExit(f"{arguments}: exit status {done.returncode}\n{done.stdout}{done.stderr}")
    return done


def _standard_models_are_compiled() -> None:
    found = json.loads(_run("-c", STANDARD).stdout)
    print("instruction sets that run here:", ", ".join(found["targets"]))
    for name, (origin, folder) in found["origins"].items():
        expected = ("shipped", f"{name}-{found['targets'][0]}")
        _demand((origin, folder) == expected, f"{name}: {origin} from {folder}, not {expected}")
    _demand(len(found["origins"]) >= 7, f"standard models: {sorted(found['origins'])}")
    _run("-c", SOLVE)
    _run("-m", "arael", "demo", "linear")
    if "x86-64-v3" in found["targets"]:
        _run("-c", OLDER)
    print("standard models: compiled, from the wheel")


def _paths_stay_behind(without: list[bytes]) -> None:
    place = _run("-c", "import arael; print(arael.__file__)").stdout.strip()
    models = Path(place).parent / "models"
    _demand("site-packages" in place, f"arael comes from {place}, not from the environment")
    for file in sorted(p for p in models.rglob("*") if p.is_file() and p.suffix != ".pyc"):
        content = file.read_bytes()
        for text in without:
            _demand(text not in content, f"{file} contains {text.decode()}")
        if file.suffix == ".json":
            absolute = re.search(rb'"(/|[A-Za-z]:\\\\)[^"]*"', content)
            _demand(absolute is None, f"{file} contains {absolute and absolute[0].decode()}")
    print("standard models: no path of the build")


def _own_model_is_interpreted() -> None:
    Path("own.arael").write_text(OWN, encoding="utf-8")
    Path("points.json").write_text(json.dumps(POINTS), encoding="utf-8")
    done = _run("-m", "arael", "solve", "own.arael", "points.json", "--json", warns=True)
    _demand("expression machine" in done.stderr, f"no such warning: {done.stderr}")
    _demand("converged" in done.stdout, f"own model: {done.stdout}")
    print("own model: interpreted, with a warning")


def _doctor_is_content() -> None:
    found = json.loads(_run("-m", "arael", "doctor", "--json").stdout)["findings"]
    (compiler,) = [f for f in found if f["name"] == "C compiler"]
    _demand(compiler["state"] == "missing", f"a compiler was found: {compiler}")
    print("doctor: no compiler, nothing broken")


def _demand(holds: bool, otherwise: str) -> None:
    if not holds:
        raise SystemExit(otherwise)


if __name__ == "__main__":
    main()

"""Builds the Cython runtime and compiles the standard models into the package."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
RUNTIME = Path("arael", "runtime")

# Where the .pyx files of the package are; those of `arael/models` are made with the models.
COMPILED = (RUNTIME, Path("arael", "starts"))

# Code that Cython would otherwise repeat in every module: memoryviews, above all.
SHARED = "arael.runtime._cyutility"
SHARED_C = RUNTIME / "_cyutility.c"

# What is written from the table of operations.
INSTRUCTIONS = RUNTIME / "machine" / "instructions.h"

# Where the C compiler spends longest: these start first, so that none is left alone at the end.
LONGEST = ("tiles", "eliminate", "reduction", "_cyutility")

# Optimised less: what orders and plans once a structure, in loops that do not vectorise
# (first solves differ by no more than their spread); and what is small or only hands calls on.
PLANNING = ("independent", "minimum_degree", "reduction", "separators", "supernodes")
PLAIN = (
    "_cyutility", "blas", "cholmod", "front_time", "heap", "kept", "lapack_band", "raised",
    "siblings", "trees",
)  # fmt: skip


def flags(name):
    """Options of the C compiler for the module `name`."""
    if sys.platform == "win32":
        return ["/O1" if name in PLAIN else "/O2"]
    level = "-O1" if name in PLAIN else "-O2" if name in PLANNING else "-O3"
    return [level, "-fno-math-errno", "-fno-trapping-math", "-g0", "-w"]


def extension(source):
    """Describe the module made from `source`, a `.pyx` or `.c` file."""
    import numpy  # a requirement of the build; its headers say where the scalars of arrays are

    return Extension(
        ".".join(source.with_suffix("").parts),
        [str(source)],
        include_dirs=[numpy.get_include()],
        define_macros=[("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION")],
        extra_compile_args=[
            *flags(source.stem),
            *os.environ.get("ARAEL_RUNTIME_CFLAGS", "").split(),
        ],
        extra_link_args=os.environ.get("ARAEL_RUNTIME_LDFLAGS", "").split(),
    )


def extensions():
    """One extension per .pyx file of the package, and the one that they share."""
    sources = [p.relative_to(ROOT) for part in COMPILED for p in (ROOT / part).rglob("*.pyx")]

    def order(path):
        return path.stem not in LONGEST, str(path)

    return [extension(path) for path in sorted([*sources, SHARED_C], key=order)]


def generate_shared():
    """Write the C file of the shared module, unless this Cython has written it."""
    from Cython.Utils import file_generated_by_this_cython

    if not file_generated_by_this_cython(str(SHARED_C)):
        subprocess.run(
            [sys.executable, "-m", "cython", f"--generate-shared={SHARED_C}"],
            check=True,
            env=environment(),
        )


def generate_instructions():
    """Write the header with the instructions of the expression machine, if it has changed."""
    subprocess.run(
        [sys.executable, "-m", "arael.operations.instructions", str(ROOT / INSTRUCTIONS)],
        check=True,
        env=environment(),
    )


def environment():
    """Give a child process the packages that this process finds."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)])}


class BuildPy(build_py):
    """Also puts the grammar inside the package."""

    def run(self):
        """Copy the package, then the grammar."""
        super().run()
        if not self.editable_mode:
            target = Path(self.build_lib) / "arael" / "grammar"
            target.mkdir(parents=True, exist_ok=True)
            for path in (ROOT / "grammar").glob("arael.*"):
                shutil.copyfile(path, target / path.name)


class BuildExt(build_ext):
    """Runs Cython on several processors, and compiles the standard models at the same time."""

    def initialize_options(self):
        """Compile as many extensions at a time as there are processors."""
        super().initialize_options()
        self.parallel = os.cpu_count() or 1

    def run(self):
        """Build the extensions and the models."""
        shipping = self.start_shipping()
        try:
            self.cythonize()
            super().run()
        except BaseException:
            if shipping:
                shipping.kill()
                shipping.wait()
            raise
        if shipping and shipping.wait():
            raise SystemExit("the standard models could not be compiled; the reason is above")

    def cythonize(self):
        """Turn the .pyx files that have changed into C."""
        from Cython.Build import cythonize

        generate_shared()
        generate_instructions()
        made = cythonize(
            [e for e in self.extensions if e.name != SHARED],
            compiler_directives={"language_level": 3, "auto_pickle": False},
            shared_utility_qualified_name=SHARED,
            nthreads=self.parallel,
            quiet=True,
        )
        of = {e.name: e for e in self.extensions}
        for found in made:  # other objects: setuptools keeps notes of its own on those it has
            own = of[found.name]
            own.sources, own.depends = found.sources, found.depends
            own.include_dirs = found.include_dirs

    def start_shipping(self):
        """Start to compile the standard models; they need no extension of the runtime."""
        if os.environ.get("ARAEL_SHIP_MODELS", "1") == "0":  # while working on the compiler
            return None
        package = ROOT if self.inplace or self.editable_mode else Path(self.build_lib)
        target = package.resolve() / "arael" / "models"
        return subprocess.Popen(
            [sys.executable, "-m", "arael.compiler.ship", str(ROOT / "models"), str(target)],
            env=environment(),
        )


if __name__ == "__main__":  # Cython's processes may import this file
    setup(ext_modules=extensions(), cmdclass={"build_py": BuildPy, "build_ext": BuildExt})

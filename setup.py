"""Builds the Cython runtime and compiles the standard models into the package."""

import os
import shutil
import sys
from pathlib import Path

import numpy
from Cython.Build import cythonize
from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent

if sys.platform == "win32":
    FLAGS = ["/O2"]
else:
    FLAGS = ["-O3", "-fno-math-errno", "-fno-trapping-math", "-g0"]
FLAGS += os.environ.get("ARAEL_RUNTIME_CFLAGS", "").split()


def extensions():
    """One extension per .pyx file of the runtime."""
    sources = sorted((ROOT / "arael" / "runtime").rglob("*.pyx"))
    names = [".".join(p.relative_to(ROOT).with_suffix("").parts) for p in sources]
    return cythonize(
        [
            Extension(
                name,
                [str(path.relative_to(ROOT))],
                extra_compile_args=FLAGS,
                extra_link_args=os.environ.get("ARAEL_RUNTIME_LDFLAGS", "").split(),
                include_dirs=[numpy.get_include()],
                define_macros=[("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION")],
            )
            for name, path in zip(names, sources, strict=True)
        ],
        compiler_directives={"language_level": 3},
        nthreads=0,
        quiet=True,
    )


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
    """Also compiles the standard models, once the runtime's extensions are there."""

    def initialize_options(self):
        """Compile the extensions two at a time."""
        super().initialize_options()
        self.parallel = os.cpu_count() or 1

    def run(self):
        """Build the extensions, then the models."""
        super().run()
        if os.environ.get("ARAEL_SHIP_MODELS", "1") == "0":  # while working on the compiler
            return
        sys.path.insert(0, str(ROOT))
        from arael.compiler.ship import ship
        from arael.diagnostics.records import AraelError
        from arael.diagnostics.render import render

        package = ROOT if self.inplace or self.editable_mode else Path(self.build_lib)
        try:
            ship(sorted((ROOT / "models").glob("*.arael")), package / "arael" / "models")
        except AraelError as error:
            raise SystemExit(render(error.diagnostics)) from None


setup(ext_modules=extensions(), cmdclass={"build_py": BuildPy, "build_ext": BuildExt})

"""Builds the Cython runtime and compiles the standard models into the package."""

import os
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.modified import newer_group

ROOT = Path(__file__).resolve().parent
sys.path.insert(0, str(ROOT))  # the build asks the package what it is built for
RUNTIME = Path("arael", "runtime")

# Where the .pyx files of the package are; those of `arael/models` are made with the models.
COMPILED = (RUNTIME, Path("arael", "starts"))

# Code that Cython would otherwise repeat in every module: memoryviews, above all.
SHARED = "arael.runtime._cyutility"
SHARED_C = RUNTIME / "_cyutility.c"

# What is written from the table of operations.
INSTRUCTIONS = RUNTIME / "machine" / "instructions.h"

# Bundles the page of the sketch editor.
ESBUILD = "esbuild@0.25.12"

# Where the C compiler spends longest: these start first, so that none is left alone at the end.
LONGEST = ("linear/compiled", "levels/compiled", "levenberg/compiled")

# Optimised most. Rows of sketches take 16 % longer with -O2; the machine's loops over lanes and the
# dense kernels are loops of vectors. Solves and edits elsewhere take as long with -O2.
HOT = (
    "levels/compiled", "machine/compiled", "linear/tiles", "linear/eliminate",
    "incremental/compiled",
)  # fmt: skip

# Optimised least: what plans once a structure or hands calls on. Analyses take as long as with -O3.
PLAIN = (
    "_cyutility", "runtime/compiled", "parallel/compiled", "linear/planning", "levels/planning",
    "orthogonal/exchange",
)  # fmt: skip

# Dense kernels in C, a compilation for each instruction set, and its options.
KERNELS = ("linear/tiles.c", "linear/eliminate.c")
KERNELS_OF = "arael.runtime.linear.compiled"
AVX2 = ["-mavx2", "-mfma"]
AVX512 = ["-mavx512f", "-mavx512vl", "-mavx512dq", "-mfma"]


def kernel_sets():
    """Instruction sets of the kernels: the baseline, and the best of this machine or all of x86."""
    from arael.compiler import processor

    built = processor.built_targets()
    if "x86-64-v3" not in processor.shipped_targets():
        return {"base": []}
    return (
        {"base": ["-O1"]}  # of x86-64: processors without AVX2
        | ({"avx2": AVX2} if "x86-64-v3" in built else {})
        | ({"avx512": AVX512} if "x86-64-v4" in built else {})
    )


def is_among(source, names):
    """Whether `source` is one of the named modules of the runtime."""
    return source.with_suffix("").as_posix().endswith(names)


def flags(source):
    """Options of the C compiler for the module of `source`."""
    if sys.platform == "win32":
        return ["/O2"]
    level = "-O3" if is_among(source, HOT) else "-O1" if is_among(source, PLAIN) else "-O2"
    given = os.environ.get("ARAEL_RUNTIME_CFLAGS", "").split()
    return [level, "-fno-math-errno", "-fno-trapping-math", "-g0", "-w", *given]


def extension(source):
    """Describe the module made from `source`, a `.pyx` or `.c` file."""
    import numpy  # a requirement of the build; its headers say where the scalars of arrays are

    return Extension(
        ".".join(source.with_suffix("").parts),
        [str(source)],
        include_dirs=[numpy.get_include()],
        define_macros=[
            ("NPY_NO_DEPRECATED_API", "NPY_1_7_API_VERSION"),
            *((f"KERNELS_{name.upper()}", "1") for name in kernel_sets()),
        ],
        extra_compile_args=flags(source),
        extra_link_args=os.environ.get("ARAEL_RUNTIME_LDFLAGS", "").split(),
    )


def extensions():
    """One extension per .pyx file, which includes the files of its package; what they share."""
    sources = [p.relative_to(ROOT) for part in COMPILED for p in (ROOT / part).rglob("*.pyx")]

    def order(path):
        return not is_among(path, LONGEST), str(path)

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


def bundle_page(page):
    """Put all modules of the sketch editor's page into the one that it loads, by esbuild.

    Where there is no Node, or npm cannot be reached, the page stays the modules that it is made of.
    """
    npx = shutil.which("npx")
    if npx is None:
        return False
    made = page / "bundle.js"
    command = [npx, "--yes", ESBUILD, "page.js", "--bundle", "--minify", "--format=esm"]
    try:
        subprocess.run(
            [*command, f"--outfile={made.name}"],
            cwd=page,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=120,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as failure:
        print(f"the page of the sketch editor is not bundled: {failure}")
        made.unlink(missing_ok=True)
        return False
    made.replace(page / "page.js")
    return True


class BuildPy(build_py):
    """Also puts the grammar inside the package, and bundles the page of the sketch editor."""

    def run(self):
        """Copy the package, then the grammar; bundle the page."""
        super().run()
        if not self.editable_mode:
            target = Path(self.build_lib) / "arael" / "grammar"
            target.mkdir(parents=True, exist_ok=True)
            for path in (ROOT / "grammar").glob("arael.*"):
                shutil.copyfile(path, target / path.name)
            bundle_page(Path(self.build_lib) / "arael" / "sketch" / "page")


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

    def build_extension(self, ext):
        """Build an extension; that of the linear solvers with the kernels of all sets."""
        if ext.name == KERNELS_OF:
            read = [*(RUNTIME / "linear").glob("*.h"), *(RUNTIME / source for source in KERNELS)]
            ext.depends = [*ext.depends, *map(str, read)]
            made = self.get_ext_fullpath(ext.name)
            if self.force or newer_group([*ext.sources, *ext.depends], made, "newer"):
                ext.extra_objects = self.kernels()
        super().build_extension(ext)

    def kernels(self):
        """Compile the kernels in C, several at a time; return the object files."""

        def compiled(job):
            (name, options), source = job
            return self.compiler.compile(
                [str(RUNTIME / source)],
                output_dir=os.path.join(self.build_temp, name),
                macros=[(f"SET_{name.upper()}", "1")],
                extra_postargs=[*flags(RUNTIME / source), *options],
            )

        jobs = [(one, source) for source in KERNELS for one in kernel_sets().items()]
        with ThreadPoolExecutor(self.parallel) as pool:
            return [path for found in pool.map(compiled, jobs) for path in found]

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

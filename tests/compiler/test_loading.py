import json
import subprocess
import sys

import pytest

import arael
from arael.diagnostics.records import AraelError
from arael.loading import load_compiled, standard_models

SLOW = (
    "lark",
    "sympy",
    "Cython",
    "setuptools",
    "filelock",
    "arael.compiler.compilation",
    "scipy.linalg",
    "scipy.sparse",
    "arael.syntax.parser",
)


def test_every_standard_model_loads() -> None:
    assert set(standard_models()) >= {
        "linear",
        "slam",
        "localization",
        "pose_graph_2d",
        "pose_graph_3d",
    }
    for name in standard_models():
        assert load_compiled(name).kernels is not None


def test_warm_start_imports_neither_the_language_nor_build_tools() -> None:
    load_compiled("linear", precision="f64")
    code = (
        "import json, sys, arael\n"
        "line = arael.load('linear', precision='f64')()\n"
        "line.data.extend(x=[0.0, 1.0, 2.0], y=[1.0, 3.0, 5.0])\n"
        "line.solve()\n"
        f"print(json.dumps([m for m in {SLOW!r} if m in sys.modules]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == []


def test_import_of_arael_alone_imports_no_numpy() -> None:
    code = "import sys, arael; print('numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_unknown_model_names_the_standard_ones_and_suggests() -> None:
    with pytest.raises(AraelError) as error:
        arael.load("slamm")
    (found,) = error.value.diagnostics
    assert found.code == "E0812"
    assert "did you mean `slam`?" in found.help
    assert "pose_graph_3d" in found.notes[0]


def test_unknown_precision_is_refused() -> None:
    with pytest.raises(AraelError, match="f16"):
        arael.load("linear", precision="f16")  # type: ignore[arg-type]


def test_models_are_importable_by_name() -> None:
    from arael.models import linear

    assert linear.__name__ == "LinearModel"
    with pytest.raises(ImportError):
        from arael.models import nothing_of_the_kind  # noqa: F401


def test_precision_overrides_the_root() -> None:
    assert load_compiled("linear").layout.precision == "f32"
    assert load_compiled("linear", precision="f64").layout.precision == "f64"


@pytest.mark.parametrize("model", [3, None])
def test_what_is_no_path_is_no_model(model: object) -> None:
    with pytest.raises(AraelError, match="E0812") as raised:
        arael.load(model)  # type: ignore[arg-type]
    assert f"found {type(model).__name__}" in str(raised.value)


def test_a_model_loaded_again_has_the_layout_of_before_and_data_of_its_own() -> None:
    one, other = (arael.load("linear")() for _ in range(2))
    assert one._compiled.layout is other._compiled.layout
    one.data.extend(x=[0.0], y=[1.0])
    assert len(other.data) == 0

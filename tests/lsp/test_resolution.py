"""Definition, uses and rename."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.records import Source
from arael.lsp.document import analyse
from arael.lsp.renaming import Refused, edited, rename, uses
from arael.lsp.workspace import Workspace
from tests.lsp.texts import MODEL, at, document, folder

MODELS = sorted(Path(__file__).parents[2].glob("models/*.arael"))


@pytest.mark.parametrize(
    ("mark", "declared"),
    [
        ("before.he|ading", "heading|: angle"),
        ("before.po|s", "pos|: vec2 [m]\n    param heading"),
        ("(pos| - before", "pos|: vec2 [m]\n    param heading"),
        ("beacon.po|s -", "pos|: vec2 [m]\n}"),
        ("pose.po|s)", "pos|: vec2 [m]\n    param heading"),
        ("path.sigm|a\n    }\n}\n\nstruct Sight", "sigma|: real"),
        ("ref Beac|on", "struct Beacon|"),
        ("in root.pose|s?", "poses|: list"),
        ("freeze beacon|s", "beacons|: list"),
        ("(ste|p - odo)", "let step|"),
        ("max(x| -", "beyond(x|"),
        ("let before = pre|v", "prev|: ref"),
    ],
)
def test_definition(mark: str, declared: str) -> None:
    symbol = document().symbol_at(at(MODEL, mark))
    assert symbol is not None
    assert symbol.span.end == at(MODEL, declared)


def test_every_name_of_the_standard_models_has_a_declaration() -> None:
    from arael.check.builtins import BUILTIN_NAMES
    from arael.check.types import TYPE_NAMES
    from arael.config import LmConfig

    assert MODELS
    known = BUILTIN_NAMES | TYPE_NAMES | set(vars(LmConfig)) | set(LmConfig.__dataclass_fields__)
    known |= {"x", "y", "z", "w", "vec", "value", "m", "rad", "px", "f32", "f64", "normal"}
    for path in MODELS:
        model = document(path.read_text(), str(path))
        unknown = {
            token.text
            for i, token in enumerate(model.tokens)
            if token.type == "NAME" and token.text not in known and model.symbol_of(i) is None
        }
        assert not unknown, path


def test_uses_of_a_field_in_two_structs() -> None:
    model = document()
    symbol = model.symbol_at(at(MODEL, "beacon.po|s -"))
    assert symbol is not None
    found = uses(model, symbol, Workspace())
    lines = sorted(model.source.position(s.start)[0] for s in found)
    assert [MODEL.splitlines()[n - 1].strip() for n in lines] == [
        "param pos: vec2 [m]",
        "(norm(beacon.pos - pose.pos) - range) / path.sigma",
        "pass start { freeze beacons.pos }",
    ]


def test_rename_changes_all_uses_and_nothing_else() -> None:
    model = document()
    edits = rename(model, at(MODEL, "beacon.po|s -"), "where", Workspace())
    changed = edited(MODEL, edits["model.arael"])
    assert changed == MODEL.replace("param pos: vec2 [m]\n}", "param where: vec2 [m]\n}").replace(
        "beacon.pos", "beacon.where"
    ).replace("beacons.pos", "beacons.where")
    assert not document(changed).findings


@pytest.mark.slow
def test_rename_of_a_struct_renames_its_row() -> None:
    text = MODEL.replace("(step - odo)", "(step - pose.odo)")
    edits = rename(document(text), at(text, "struct Po|se"), "Stop", Workspace())
    changed = edited(text, edits["model.arael"])
    assert "struct Stop {" in changed
    assert "pose: ref Stop in root.poses" in changed  # a field of that name stays
    assert "(step - stop.odo)" in changed
    assert not document(changed).findings


@pytest.mark.sweep(3)
@pytest.mark.parametrize(
    ("mark", "new", "why"),
    [
        ("beacon.po|s -", "sin", "belongs to the language"),
        ("beacon.po|s -", "constraint", "belongs to the language"),
        ("beacon.po|s -", "2x", "is not a name"),
        ("(ste|p - odo)", "odo", "means two things"),
        ("odo|: vec2", "heading", "declared twice"),
        ("struct Po|se", "Beacon", "declared twice"),
        ("nor|m(", "length", "not a name that the model declares"),
    ],
)
def test_rename_is_refused(mark: str, new: str, why: str) -> None:
    with pytest.raises(Refused) as error:
        rename(document(), at(MODEL, mark), new, Workspace())
    assert why in str(error.value)


def test_rename_over_files(tmp_path: Path) -> None:
    parts, main = MODEL.split("struct Pose {", 1)
    main = 'import "parts.arael"\n\nstruct Pose {' + main
    folder(tmp_path, parts=parts, main=main)
    path = tmp_path / "parts.arael"
    shared = Workspace()
    model = analyse(Source(str(path), parts), shared)
    assert not model.findings  # a file without a root is a part of others
    edits = rename(model, at(parts, "param po|s"), "where", shared)
    assert {Path(name).name for name in edits} == {"parts.arael", "main.arael"}
    own = edits[str(tmp_path / "main.arael")]
    assert [text for _, text in own] == ["where", "where"]
    assert "beacon.where - pose.pos" in edited(main, own)

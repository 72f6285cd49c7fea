"""Reading model files from disk."""

import os
from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError, Diagnostic
from arael.syntax.files import read_source
from arael.syntax.limits import MAX_BYTES
from arael.syntax.parser import parse


def refusal(path: Path) -> Diagnostic:
    with pytest.raises(AraelError) as caught:
        read_source(path)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.span is not None or str(path) in diagnostic.origin
    return diagnostic


def test_text_comes_back_without_its_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_bytes(b"\xef\xbb\xbfroot R { x: real }\r\n# \xc3\xa9\r\n")
    source = read_source(path)
    assert source.name == str(path)
    assert source.text == "root R { x: real }\r\n# é\r\n"


def test_missing_file_suggests_a_neighbour(tmp_path: Path) -> None:
    (tmp_path / "slam.arael").write_text("root R { x: real }")
    found = refusal(tmp_path / "slma.arael")
    assert found.code == "E0101"
    assert "slam.arael" in found.help[0]
    assert "slam.arael" in refusal(tmp_path / "slam").help[0]
    assert refusal(tmp_path / "nowhere" / "x.arael").code == "E0101"


def test_a_link_to_itself_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.arael").symlink_to("b.arael")
    (tmp_path / "b.arael").symlink_to("a.arael")
    assert refusal(tmp_path / "a.arael").code == "E0102"


def test_folder(tmp_path: Path) -> None:
    (tmp_path / "slam.arael").write_text("root R { x: real }")
    found = refusal(tmp_path)
    assert (found.code, "slam.arael" in found.help[0]) == ("E0102", True)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_pipes_are_not_read(tmp_path: Path) -> None:
    path = tmp_path / "pipe"
    os.mkfifo(path)
    assert refusal(path).code == "E0102"


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="this system has no such permissions")
def test_unreadable_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.arael"
    path.write_text("root R { x: real }")
    if os.geteuid() == 0:  # root may read everything: refuse on its behalf

        def refuse(*_: object) -> None:
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr("builtins.open", refuse)
    else:
        path.chmod(0)
    found = refusal(path)
    assert (found.code, found.message) == ("E0102", "this file cannot be read: permission denied")


@pytest.mark.parametrize(
    ("data", "code"),
    [
        (b"", "E0107"),
        (b"  \n\t\n", "E0107"),
        (b"# only\n  # comments\n", "E0107"),
        (b"root R { x: real }\n\xff", "E0103"),
        (b"root R\0", "E0103"),
        ("root R".encode("utf-16"), "E0103"),
        (b"#" * (MAX_BYTES + 1), "E0104"),
    ],
)
def test_contents(tmp_path: Path, data: bytes, code: str) -> None:
    path = tmp_path / "m.arael"
    path.write_bytes(data)
    assert refusal(path).code == code


def test_bad_byte_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_bytes(b"root R {\n  x: real\n  # \xe9\n}")
    assert refusal(path).message == "this file is not UTF-8: byte 0xe9 in line 3"


@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"], ids=["plain", "byte order mark"])
@pytest.mark.parametrize(
    ("bad", "label"),
    [(b"\xe9", "not a character in UTF-8"), (b"\xed\xa0\x80", "an unpaired surrogate")],
    ids=["latin-1", "surrogate"],
)
def test_bad_byte_is_shown_in_its_place(
    tmp_path: Path, mark: bytes, bad: bytes, label: str
) -> None:
    path = tmp_path / "m.arael"
    path.write_bytes(mark + "# é\r\nroot R { é".encode() + bad + b" }")
    found = refusal(path)
    assert str(found.span) == f"{path}:2:11"
    assert found.label == label
    assert f"byte 0x{bad[0]:02x} in line 2" in found.message


def test_places_do_not_count_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "m.arael"
    path.write_bytes(b"\xef\xbb\xbfroot R { x real }")
    with pytest.raises(AraelError) as caught:
        parse(read_source(path))
    assert str(caught.value.diagnostics[0].span).endswith("m.arael:1:11")


def test_name_with_a_zero_byte() -> None:
    with pytest.raises(AraelError):
        read_source("a\0b")

"""``skip`` fields are data that constraints do not see; a ref may be one."""

from pathlib import Path

import arael

TEXT = """
struct Camera { f: real }
struct Feature {
    skip camera: ref Camera in root.cameras
    skip note: string = "seen"
    param x: real
    constraint c { x - 1 }
}
root Scene { cameras: list of Camera; features: list of Feature }
"""


def test_a_skipped_ref_is_carried_along(tmp_path: Path) -> None:
    (tmp_path / "scene.arael").write_text(TEXT, encoding="utf-8")
    scene = arael.load(tmp_path / "scene.arael", interpret=True)()
    camera = scene.cameras.append(f=500.0)
    scene.features.append(camera=camera, x=0.0)
    scene.write(tmp_path / "scene.json")
    again = type(scene)()
    again.read(tmp_path / "scene.json")
    again.solve()
    assert again.features[0].camera == again.cameras[0]
    assert again.features[0].camera.f == 500.0 and again.features[0].note == "seen"

"""Writing the camera of a scene file: that table alone changes, and the file is replaced whole or not at all."""

import os
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import surflux as sf

CAMERA = sf.Camera([1.5, -4.25, 2.0], [0.0, 0.5, 1.0], fov=38.5)
TURNED = sf.Camera([0, 0, 5], [0, 0, 0], up=(0, 1, 0))
FULL = """# A scene.
name = "room" # its name

[[object]]
shape = "sphere"   # (round)
points = 42

[camera]  # where from
# the eye stands in the door
eye = [ 1, 2,
        3 ] # three
target = [0,0,0]# middle
  fov=  50   # wide

# the lamp
[[light]]
type = "environment"
radiance = 1.0
"""
CHANGED = """# A scene.
name = "room" # its name

[[object]]
shape = "sphere"   # (round)
points = 42

[camera]  # where from
# the eye stands in the door
eye = [1.5, -4.25, 2.0] # three
target = [0.0, 0.5, 1.0]# middle
  fov = 38.5   # wide

# the lamp
[[light]]
type = "environment"
radiance = 1.0
"""


def written(tmp_path, text, camera=CAMERA):
    path = tmp_path / "scene.toml"
    path.write_bytes(text.encode())
    sf.save_camera(path, camera)
    return path.read_bytes().decode()


def test_only_the_values_of_the_camera_change(tmp_path):
    assert written(tmp_path, FULL) == CHANGED
    assert sf.load_scene(tmp_path / "scene.toml").camera == CAMERA
    assert written(tmp_path, CHANGED) == CHANGED


def test_what_the_table_lacks_is_added_to_it(tmp_path):
    text = written(tmp_path, FULL, TURNED)
    assert "  fov = 45.0   # wide\nup = [0.0, 1.0, 0.0]\n\n# the lamp\n" in text
    assert sf.load_scene(tmp_path / "scene.toml").camera == TURNED


def test_a_file_without_a_camera_gets_one(tmp_path):
    text = '[[object]]\nshape = "sphere"'
    assert (
        written(tmp_path, text)
        == text + "\n\n[camera]\neye = [1.5, -4.25, 2.0]\ntarget = [0.0, 0.5, 1.0]\nfov = 38.5\n"
    )
    assert written(tmp_path, "[camera]") == "[camera]\neye = [1.5, -4.25, 2.0]\ntarget = [0.0, 0.5, 1.0]\nfov = 38.5\n"
    assert tomllib.loads(written(tmp_path, "", TURNED)) == {
        "camera": {"eye": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0]}
    }


def test_ends_of_lines_stay(tmp_path):
    text = written(tmp_path, FULL.replace("\n", "\r\n"))
    assert text == CHANGED.replace("\n", "\r\n")
    assert written(tmp_path, 'name = "a"\r\n').endswith(
        "\r\n[camera]\r\neye = [1.5, -4.25, 2.0]\r\ntarget = [0.0, 0.5, 1.0]\r\nfov = 38.5\r\n"
    )


def test_places_in_survey_coordinates_keep_their_digits(tmp_path):
    camera = sf.Camera([5000001.75, 6000002.25, 1.25], [5000000.5, 6000000.125, 0.5])
    found = written(tmp_path, FULL, camera)
    table = tomllib.loads(found)["camera"]
    assert table["eye"] == camera.eye.tolist()
    assert table["target"] == camera.target.tolist()


def test_other_separators_end_no_line(tmp_path):
    text = "# one\u2028[camera]\n[camera]\neye = [0, 1, 2] # x\x85y\ntarget = [0, 0, 0]\n"
    found = written(tmp_path, text)
    assert "# one\u2028[camera]\n[camera]\neye = [1.5, -4.25, 2.0] # x\x85y\n" in found


def test_headers_inside_texts_and_lists_are_none(tmp_path):
    text = 'about = """\n[camera]\neye = no\n"""\nlist = [\n[1],\n]\n[camera]\neye = [1, 1, 1]\ntarget = [0, 0, 0]\n'
    changed = written(tmp_path, text)
    assert changed.startswith('about = """\n[camera]\neye = no\n"""\nlist = [\n[1],\n]\n[camera]\neye = [1.5')


def test_every_scene_of_the_project_takes_a_camera(tmp_path):
    for scene in sorted((Path(__file__).parents[3] / "data").glob("*.toml")):
        text = scene.read_text()
        before, after = tomllib.loads(text), tomllib.loads(written(tmp_path, text))
        assert after.pop("camera") == {
            k: v for k, v in CAMERA.to_dict().items() if k in after.get("camera", {}) or k != "up"
        } | ({"up": [0.0, 0.0, 1.0]} if "up" in before.get("camera", {}) else {})
        before.pop("camera", None)
        assert after == before
        lines = written(tmp_path, text).splitlines()
        assert [line for line in text.splitlines() if line.startswith("#")] == [
            line for line in lines if line.startswith("#")
        ]


names = st.text("abcdefgh_", min_size=1, max_size=4).filter(lambda name: name != "camera")
values = st.one_of(
    st.integers(-99, 99).map(str),
    st.just('"[camera]"'),
    st.just("[\n [1], # [camera]\n]"),
    st.just("'''\n[camera]\n'''"),
)
lines = st.one_of(st.just(""), st.just("# [camera]"), st.just("   # eye = 3"))


@pytest.mark.slow
@given(
    st.lists(st.tuples(names, values), max_size=3, unique_by=lambda pair: pair[0]),
    st.lists(
        st.tuples(st.sampled_from(["eye", "up", "fov", "extra", "target"]), values, lines),
        max_size=4,
        unique_by=lambda e: e[0],
    ),
    st.booleans(),
    st.booleans(),
)
def test_any_file_keeps_all_else(tmp_path_factory, before, table, end, tail):
    text = "".join(f"{name} = {value}\n" for name, value in before)
    text += "".join(["[camera]\n", *(f"{key} = {value}\n{line}\n" for key, value, line in table)])
    text += "[tail]\nx = 1\n# end\n" if tail else ""
    text = text if end else text.rstrip("\n")
    old, new = tomllib.loads(text), tomllib.loads(written(tmp_path_factory.mktemp("camera"), text))
    camera = new.pop("camera")
    assert {"up": [0, 0, 1]} | {k: v for k, v in camera.items() if k != "extra"} == CAMERA.to_dict()
    assert camera.get("extra") == old["camera"].get("extra")
    old.pop("camera")
    assert new == old


WRONG = [
    (
        "camera = { eye = [1, 2, 3], target = [0, 0, 0] }\n",
        r"scene\.toml \(camera\): is not a table headed \[camera\], and cannot",
    ),
    ("camera.eye = [1, 2, 3]\n", r"\(camera\): is not a table headed"),
    ("camera = 3\n", r"\(camera\): is not a table headed"),
    ("eye = \n", r"scene\.toml: is no TOML \(Invalid value"),
    ("[[camera]]\n", r"\(camera\): is not a table headed"),
]


@pytest.mark.parametrize(("text", "message"), WRONG)
def test_what_cannot_be_rewritten_stays(tmp_path, text, message):
    with pytest.raises(sf.FileError, match=message):
        written(tmp_path, text)
    assert (tmp_path / "scene.toml").read_text() == text
    assert os.listdir(tmp_path) == ["scene.toml"]


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(sf.FileError, match=r"none\.toml: cannot be read: No such file"):
        sf.save_camera(tmp_path / "none.toml", CAMERA)
    (tmp_path / "a.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(sf.FileError, match=r"a\.toml: is no TOML \('utf-8' codec"):
        sf.save_camera(tmp_path / "a.toml", CAMERA)
    with pytest.raises(ValueError, match=r"^camera: wanted a Camera, got int$"):
        sf.save_camera(tmp_path / "a.toml", 3)


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "scene.toml"
    path.write_text(FULL)
    path.chmod(0o640)
    link = tmp_path / "link.toml"
    link.symlink_to(path)
    sf.save_camera(link, CAMERA)
    assert link.is_symlink()
    assert path.read_text() == CHANGED
    assert path.stat().st_mode & 0o777 == 0o640

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(sf.FileError, match=r"scene\.toml: cannot be written: No space left on device"):
        sf.save_camera(path, TURNED)
    assert path.read_text() == CHANGED
    assert sorted(os.listdir(tmp_path)) == ["link.toml", "scene.toml"]

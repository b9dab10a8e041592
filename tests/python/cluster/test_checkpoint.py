"""A solve that keeps what it exchanges goes on from there to the same bits, and refuses what is not its own."""

import json
import shutil

import pytest

import surflux as sf
from scenes import cube_inside, same_bits

KNOBS = {"zeta": 0.1, "rays": 32, "probes": 4, "transport": "rays", "seed": 3}


def scene(reflectance=0.5):
    return sf.Scene([cube_inside(5, reflectance, 0.0)], [sf.PointLight([0.2, 0.3, 0.8], 1.0)])


def solved(folder=None, reflectance=0.5, **given):
    return sf.solve(scene(reflectance), **{**KNOBS, **given}, checkpoint=folder)


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """(the folder of a whole solve, its solution)."""
    folder = tmp_path_factory.mktemp("whole") / "kept"
    return folder, solved(folder)


@pytest.fixture
def copy(kept, tmp_path):
    """A copy of the folder."""
    shutil.copytree(kept[0], tmp_path / "copy")
    return tmp_path / "copy"


def exchanges(folder):
    return sorted((folder / "call-0").glob("*.exchange"))


def test_what_is_kept_changes_nothing(kept):
    assert same_bits(kept[1], solved())
    assert len(exchanges(kept[0])) > 5


@pytest.mark.parametrize("share", [0.0, 0.4, 0.8, 1.0])
def test_a_solve_goes_on_after_any_exchange(kept, copy, share):
    files = exchanges(copy)
    known = round(share * len(files))
    stamps = [file.stat().st_mtime_ns for file in files[:known]]
    for file in files[known:]:
        file.unlink()
    assert same_bits(solved(copy), kept[1])
    assert len(exchanges(copy)) == len(files)
    assert [file.stat().st_mtime_ns for file in files[:known]] == stamps, "what was known was made again"
    assert [file.read_bytes() for file in exchanges(copy)] == [file.read_bytes() for file in exchanges(kept[0])]


def test_a_solve_that_is_cancelled_goes_on(kept, tmp_path):
    with pytest.raises(sf.Cancelled):
        solved(tmp_path / "kept", progress=lambda done, total: len(exchanges(tmp_path / "kept")) < 3)
    assert 0 < len(exchanges(tmp_path / "kept")) < len(exchanges(kept[0]))
    assert same_bits(solved(tmp_path / "kept"), kept[1])


def test_every_attempt_at_an_error_is_kept(tmp_path):
    asked = {"error": 0.02, "transport": "rays", "seed": 3}
    wanted = sf.solve(scene(), **asked)
    for _ in range(2):
        found = sf.solve(scene(), **asked, checkpoint=tmp_path / "kept")
        assert same_bits(found, wanted)
        assert len(list((tmp_path / "kept").iterdir())) == len(found.attempts)


@pytest.mark.parametrize("at", [0, 30, 60, 90, -1])
def test_a_damaged_file_is_refused_by_name_and_place(copy, at):
    file = exchanges(copy)[2]
    data = bytearray(file.read_bytes())
    data[at] ^= 1
    file.write_bytes(data)
    with pytest.raises(sf.FileError, match=rf"{file} \((from )?byte \d+\): is (damaged|no exchange|cut off)"):
        solved(copy)


@pytest.mark.parametrize("length", [0, 10, 30, 200])
def test_a_file_that_is_cut_off_is_refused(copy, length):
    file = exchanges(copy)[1]
    file.write_bytes(file.read_bytes()[:length])
    with pytest.raises(sf.FileError, match=rf"{file} \(byte \d+\): is (cut off|no exchange)"):
        solved(copy)


def test_files_in_another_order_are_refused(copy):
    first, second = exchanges(copy)[:2]
    first.write_bytes(second.read_bytes())
    with pytest.raises(sf.FileError, match=r"00000\.exchange \(byte 67\): is exchange 1, '.*', where exchange 0 was"):
        solved(copy)


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"zeta": 0.2}, "option zeta is 0.1, wanted 0.2"),
        ({"seed": 4}, "option seed"),
        ({"reflectance": 0.6}, r"scene's array reflectance is array of \d+ x 3, digest \w+, wanted array of "),
    ],
)
def test_the_folder_of_another_call_is_refused(copy, given, name):
    with pytest.raises(sf.FileError, match=rf"checkpoint\.json: is of another call: its {name}"):
        solved(copy, **given)


def test_the_folder_of_another_version_is_refused(copy):
    file = copy / "call-0" / "checkpoint.json"
    kept = json.loads(file.read_text())
    kept["facts"]["version of surflux"] = "0.0.1"
    file.write_text(json.dumps(kept))
    with pytest.raises(sf.FileError, match=r"another call: its version of surflux is 0\.0\.1, wanted "):
        solved(copy)
    file.write_text(json.dumps(kept | {"format": 7}))
    with pytest.raises(sf.FileError, match="is of another format, 7; wanted 2"):
        solved(copy)
    for text in ("{", "[]", '{"format": 2, "facts": 2}'):
        file.write_text(text)
        with pytest.raises(sf.FileError, match="is damaged: wanted the facts of a call, as JSON"):
            solved(copy)


def test_what_a_process_was_killed_over_is_cleared_away(tmp_path):
    """Before the folder said whose it is, and between two exchanges."""
    call = tmp_path / "call-0"
    call.mkdir()
    for _ in range(2):
        for name in (".checkpoint-123.part.json", ".00002-123.part.exchange"):
            (call / name).write_text("half of it")
        solved(tmp_path)
        assert not list(call.glob(".*"))
    assert (call / "checkpoint.json").exists()


def test_places_that_are_no_checkpoint_are_refused(tmp_path):
    (tmp_path / "file").write_text("mine")
    with pytest.raises(sf.FileError, match="file: is a file, not a folder"):
        solved(tmp_path / "file")
    with pytest.raises(sf.FileError, match="cannot be made: Not a directory"):
        solved(tmp_path / "file" / "kept")
    (tmp_path / "kept" / "call-0").mkdir(parents=True)
    (tmp_path / "kept" / "call-0" / "mine").write_text("mine")
    with pytest.raises(sf.FileError, match=r"is no checkpoint: it holds other files, and no checkpoint\.json"):
        solved(tmp_path / "kept")
    with pytest.raises(ValueError, match="checkpoint: wanted a path, got int"):
        solved(3)
    with pytest.raises(ValueError, match="seconds: does not go with cluster or checkpoint"):
        sf.solve(scene(), seconds=1.0, checkpoint=tmp_path / "new")
    assert not (tmp_path / "new").exists()

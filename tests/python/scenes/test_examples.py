"""Scenes that come with surflux."""

import numpy as np
import pytest

import surflux as sf
from quick import quick
from surflux.scenes import examples

SCENES = ("colonnade", "cornell_box", "statues", "street", "three_spheres")


def test_every_example_is_tested():
    assert {*SCENES} == {*sf.examples.__all__} - {"file", "folder", "schema"}
    assert sf.examples is examples


@pytest.mark.parametrize("name", quick("cornell_box", "three_spheres", of=SCENES))
def test_an_example_is_lit_and_keeps_its_power(name, monkeypatch):
    """Without models from elsewhere. Power that is lost is an error of the mean, which is at most that in the RMS."""
    monkeypatch.delenv("SURFLUX_DATA", raising=False)
    scene = getattr(sf.examples, name)()
    assert scene.camera is not None
    solution = sf.solve(scene, transport="rays", rays=64)
    last = solution.history[-1]
    assert abs(last["power_lost"]) <= solution.error * last["power_in"]
    lit = [np.any(solution.radiosity[solution.objects == k] > 0) for k in range(len(scene.objects))]
    assert all(lit)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_no_patches_of_an_example_lie_half_under_a_wall(name, caplog, recwarn):
    sf.solve(getattr(sf.examples, name)(), transport="rays", rays=16, insert=False)
    assert [str(w.message) for w in recwarn] == []
    assert caplog.text == ""


def test_the_number_of_surfels_can_be_chosen():
    assert sum(len(s) for s in sf.examples.statues(surfels=6000).objects) == 6000
    with pytest.raises(ValueError, match=r"^surfels: "):
        sf.examples.three_spheres(surfels=100)


def test_an_example_has_its_file():
    assert sf.load_scene(sf.examples.file("street")).name == "street"
    with pytest.raises(ValueError, match=r"name: wanted one of colonnade, cornell_box, .*, got 'sponza'"):
        sf.examples.file("sponza")


def test_an_installation_without_the_files_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(examples, "__file__", str(tmp_path / "a" / "b" / "c" / "examples.py"))
    with pytest.raises(sf.FileError, match="c/files: the scene files of surflux are missing"):
        sf.examples.statues()

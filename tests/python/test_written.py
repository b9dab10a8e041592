"""Whatever writes a file says which, as a Path, however the path was given."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf

CAMERA = sf.Camera([0, -3, 2], [0, 0, 0])


@pytest.fixture(scope="module")
def solution():
    floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]))
    return sf.solve(sf.Scene([floor], lights=[sf.Environment(1.0)]))


WRITERS = {
    "surfels.ply": lambda s, path: s.surfels.save(path),
    "solution.ply": lambda s, path: s.save(path),
    "picture.png": lambda _, path: sf.write_image(path, np.ones((2, 2, 3))),
    "picture.exr": lambda _, path: sf.write_image(path, np.ones((2, 2, 3))),
    "page.html": lambda s, path: sf.Page(s).save(path),
    "plot.png": lambda s, path: s.plot(screenshot=path, size=(40, 30)),
    "areas.png": lambda s, path: s.surfels.plot_areas(screenshot=path, size=(400, 300)),
    "view.png": lambda s, path: sf.view(s, screenshot=path, size=(40, 30)),
    "operator.npz": lambda s, path: sf.form_factor_operator(s._scene, rays=16).save(path),
    "room.transfer": lambda s, path: sf.precompute_transfer(s._scene, levels=1, rays=16).save(path),
    "gaussians.ply": lambda s, path: sf.Gaussians.of(s).save(path),
    "gaussians.glb": lambda s, path: sf.Gaussians.of(s).save(path),
    "gaussians.gltf": lambda s, path: sf.Gaussians.of(s).save(path),
    "scene.toml": lambda _, path: sf.save_camera(path, CAMERA),
}


@pytest.mark.parametrize("as_given", [str, Path])
@pytest.mark.parametrize("name", list(WRITERS))
def test_what_writes_returns_the_path(name, as_given, solution, tmp_path):
    path = tmp_path / name
    if name == "scene.toml":
        path.write_text('[[object]]\nshape = "sphere"\n')
    written = WRITERS[name](solution, as_given(path))
    assert isinstance(written, Path)
    assert written == path
    assert path.stat().st_size > 0


def test_an_animation_returns_the_paths_of_its_pictures(solution, tmp_path):
    paths = solution.animate([CAMERA] * 2, str(tmp_path / "%d.png"), (8, 6), samples=1)
    assert paths == [tmp_path / "1.png", tmp_path / "2.png"]
    assert all(isinstance(path, Path) and path.is_file() for path in paths)

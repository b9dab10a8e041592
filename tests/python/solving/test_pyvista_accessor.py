"""dataset.surflux: pyvista finds it, and light comes back on the dataset."""

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import pyvista

import surflux as sf
from surflux.solving.pyvista_accessor import PolyDataAccessor

ROOT = Path(__file__).parents[3]
SKY = [sf.Environment(1.0)]


@pytest.mark.skipif(not hasattr(pyvista, "register_dataset_accessor"), reason="pyvista 0.48 has accessors")
def test_pyvista_finds_it_when_it_is_asked_for(tmp_path):
    entries = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["entry-points"]
    (tmp_path / "surflux-0.dist-info").mkdir()
    (tmp_path / "surflux-0.dist-info/METADATA").write_text("Metadata-Version: 2.1\nName: surflux\nVersion: 0\n")
    text = "".join(f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in of.items()) for group, of in entries.items())
    (tmp_path / "surflux-0.dist-info/entry_points.txt").write_text(text)
    program = f"""import sys; sys.path.insert(0, {str(tmp_path)!r})
import pyvista; cube = pyvista.Cube(); before = "surflux" in sys.modules
print(before, len(cube.surflux.surfels()), hasattr(pyvista.ImageData(), "surflux"))"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["False", "6", "False"]


def test_surflux_does_not_bring_pyvista_along():
    program = "import sys, surflux; surflux.Scene; print('pyvista' in sys.modules)"
    assert (
        subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout == "False\n"
    )


def test_a_mesh_has_light_in_its_cells():
    """A cube alone under an even sky of radiance 1: pi everywhere. Lines, which come first, have none."""
    cube = pyvista.Cube().extract_surface(algorithm=None)
    mixed = pyvista.PolyData(cube.points, faces=cube.faces, lines=[2, 0, 1])
    lit = PolyDataAccessor(mixed).solve(SKY)
    assert np.isnan(lit.cell_data["irradiance"][0]).all()
    assert np.allclose(lit.cell_data["irradiance"][1:], np.pi, rtol=1e-6)
    assert np.allclose(lit.cell_data["radiosity"][1:], 0.5 * np.pi, rtol=1e-6)
    assert lit.cell_data["direct"].dtype == np.float32
    assert "irradiance" not in mixed.cell_data
    strips = cube.triangulate().strip()
    assert strips.n_strips > 0
    assert np.allclose(PolyDataAccessor(strips).solve(SKY).cell_data["irradiance"], np.pi, rtol=1e-6)


def test_light_of_cells_is_that_of_solve():
    mesh, floor = pyvista.Cube(center=(0, 0, 0.6)), sf.Surfels.from_mesh(pyvista.Plane(i_size=4, j_size=4), 0.1)
    patches = PolyDataAccessor(mesh).surfels(patch_area=0.1, reflectance=0.8)
    lit = PolyDataAccessor(mesh).solve([sf.PointLight([1, -2, 3], 40)], patches, [floor], seed=3)
    solution = sf.solve(sf.Scene([patches, floor], [sf.PointLight([1, -2, 3], 40)]), seed=3)
    assert np.array_equal(lit.cell_data["irradiance"], solution.per_face().astype(np.float32))


def test_a_cloud_has_light_at_its_points():
    directions = np.random.default_rng(0).normal(size=(1500, 3))
    cloud = pyvista.PolyData(directions / np.linalg.norm(directions, axis=1, keepdims=True))
    lit = PolyDataAccessor(cloud).solve([sf.DirectionalLight([0, 0, -1], 10.0)], insert=False)
    above = np.maximum(cloud.points[:, 2], 0.0)
    assert np.abs(lit.point_data["direct"][:, 0] - 10.0 * above).max() < 1.0
    surfels = PolyDataAccessor(cloud).surfels(viewpoint=[0, 0, 0])
    assert np.all(np.sum(surfels.normals * surfels.points, axis=1) < 0)
    inside = PolyDataAccessor(cloud).solve([sf.PointLight([0, 0, 0], 10.0)], surfels, insert=False)
    assert np.abs(inside["direct"][:, 0] - 10.0).max() < 1.0  # at a distance of 1


def test_surfels_of_something_else_are_refused():
    cube, cloud = pyvista.Cube(), pyvista.PolyData(np.random.default_rng(0).random((50, 3)))
    with pytest.raises(ValueError, match=r"^surfels: wanted those of the dataset's 6 faces$"):
        PolyDataAccessor(cube).solve(SKY, PolyDataAccessor(cloud).surfels())
    with pytest.raises(ValueError, match=r"^surfels: wanted one for each of the dataset's 50 points, got 6$"):
        PolyDataAccessor(cloud).solve(SKY, PolyDataAccessor(cube).surfels())
    with pytest.raises(ValueError, match=r"^surfels: wanted Surfels, got str$"):
        PolyDataAccessor(cloud).solve(SKY, "all")

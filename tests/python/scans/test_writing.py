"""Points as they are written: every format comes back, by our readers and by those of others."""

import json

import numpy as np
import pytest

import surflux as sf
from surflux.scans.writing import WRITTEN

N = 500


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def scan():
    """A survey: coordinates of half a million metres to the millimetre, colours of which each byte is one of sRGB."""
    rng = np.random.default_rng(4)
    points = np.round(rng.uniform([635000, 848000, 400], [635100, 848080, 440], (N, 3)), 3)
    normals = rng.normal(size=(N, 3))
    return sf.Scan(
        points,
        normals / np.linalg.norm(normals, axis=1, keepdims=True),
        sf.Surfels(points, normals, radii=1.0, reflectance=rng.random((N, 3)) * 0.98).reflectance,
        {
            "classification": rng.integers(0, 19, N).astype(np.uint8),
            "intensity": rng.integers(0, 65536, N).astype(np.uint16),
            "gps_time": rng.uniform(1e8, 2e8, N),
            "return_number": rng.integers(1, 6, N).astype(np.uint8),
            "point_source_id": rng.integers(0, 65536, N).astype(np.uint16),
            "amplitude": rng.normal(size=N).astype(np.float32),
        },
    )


@pytest.fixture
def found():
    rng = np.random.default_rng(5)
    irradiance = rng.random((N, 3)).astype(np.float32)
    irradiance[7] = np.nan
    return {"irradiance": irradiance, "left_out": (np.arange(N) == 7).astype(np.uint8)}


def channels(attributes, name):
    return np.stack([attributes[f"{name}_{c}"] for c in "rgb"], axis=-1)


@pytest.mark.parametrize("suffix", [s for s in WRITTEN if s not in (".vtp", ".glb", ".gltf")])
def test_what_is_written_is_read_again(here, scan, found, suffix):
    again = sf.read_scan(scan.save(f"out{suffix}", found))
    # LAS counts steps of 1e-4 of the spacing, 100 m / sqrt(500) / 1e4 or finer, in powers of ten: half of 1e-4 m.
    step = 5e-5 if suffix in (".las", ".laz") else 0.0
    assert np.abs(again.points - scan.points).max() <= step
    assert again.normals == pytest.approx(scan.normals, abs=1e-6)
    for name, values in scan.attributes.items():
        assert np.array_equal(again.attributes[name].astype(values.dtype), values), name
    irradiance = again.attributes["irradiance"] if suffix == ".npz" else channels(again.attributes, "irradiance")
    assert np.array_equal(irradiance.astype(np.float32), found["irradiance"], equal_nan=True)
    assert np.flatnonzero(again.attributes["left_out"]).tolist() == [7]
    assert np.array_equal(again.display_colors(), scan.display_colors())


def test_coordinates_of_las_come_back_bit_by_bit_with_their_reference_system(here, scan):
    laspy = pytest.importorskip("laspy")
    first = scan.save("first.las")
    with laspy.open(first) as reader:
        header = reader.header
    header.vlrs.append(laspy.vlrs.known.WktCoordinateSystemVlr('PROJCS["somewhere"]'))
    whole = laspy.read(first)
    whole.header.vlrs.append(header.vlrs[-1])
    whole.write("with.las")
    read = sf.read_scan("with.las")
    again = sf.read_scan(read[100:200].save("again.laz", {"kwh": np.arange(100.0)}))
    assert np.array_equal(again.points, read.points[100:200])
    with laspy.open("again.laz") as reader:
        assert [vlr.string for vlr in reader.header.vlrs if vlr.record_id == 2112] == ['PROJCS["somewhere"]']
        assert reader.header.scales.tolist() == header.scales.tolist()
    assert again.attributes["kwh"].tolist() == list(range(100))


def test_vtp_is_what_paraview_reads(here, scan, found):
    import pyvista

    data = pyvista.read(scan.save("out.vtp", found))
    assert np.array_equal(data.points, scan.points)
    assert np.array_equal(data.point_data["irradiance"], found["irradiance"], equal_nan=True)
    assert np.array_equal(data.point_data["RGB"], scan.display_colors())


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_has_y_up_and_linear_colours(here, scan, suffix):
    trimesh = pytest.importorskip("trimesh")
    path = scan.save(f"out{suffix}", {"kwh": np.arange(N)}, colors=np.full((N, 3), [255, 188, 0]))
    scene = trimesh.load(path)
    (cloud,) = scene.geometry.values()
    points = cloud.vertices @ scene.graph[scene.graph.nodes_geometry[0]][0][:3, :3].T
    points = points + scene.graph[scene.graph.nodes_geometry[0]][0][:3, 3]
    # Floats from the middle: half of 100 m to 24 bits.
    assert points == pytest.approx(scan.points[:, [0, 2, 1]] * [1, 1, -1], abs=50 * 2.0**-23)
    # sRGB 188 is linear .503 (IEC 61966-2-1), as bytes 128.
    assert cloud.colors[0].tolist() == [255, 128, 0, 255]
    if suffix == ".gltf":
        attributes = json.loads(path.read_text())["meshes"][0]["primitives"][0]["attributes"]
        assert set(attributes) >= {"POSITION", "NORMAL", "COLOR_0", "_KWH", "_CLASSIFICATION"}


def test_trimesh_and_pyvista_show_the_light(here, scan):
    trimesh = pytest.importorskip("trimesh")
    import pyvista

    colors = np.random.default_rng(6).integers(0, 256, (N, 3))
    path = scan.save("out.ply", colors=colors)
    assert np.array_equal(trimesh.load(path).colors[:, :3], colors)
    assert np.array_equal(pyvista.read(path).point_data["RGB"], colors)


def test_what_does_not_fit_is_refused(here, scan):
    with pytest.raises(ValueError, match=r"path: wanted a name ending in \.ply, .*\.gltf, got 'out\.xyz'"):
        scan.save("out.xyz")
    with pytest.raises(ValueError, match=rf"columns: kwh: wanted shape \({N},\) or \({N}, k\), got \(3,\)"):
        scan.save("out.ply", {"kwh": [1.0, 2.0, 3.0]})
    with pytest.raises(ValueError, match=rf"colors: wanted shape \({N}, 3\), got \({N},\)"):
        scan.save("out.ply", colors=np.zeros(N))
    with pytest.raises(ValueError, match="comments: wanted lines of text, got one with a line break"):
        scan.save("out.ply", comments=["two\nlines"])
    with pytest.raises(sf.FileError, match="classification: LAS has room from 0 to 255, got 256"):
        scan.save("out.las", {"classification": np.full(N, 256)})
    far = sf.Scan(np.array([[0.0, 0, 0], [1e12, 0, 0]]), frame=sf.read_scan(scan.save("a.las")).frame)
    with pytest.raises(sf.FileError, match="its coordinates do not fit the 32 bits"):
        far.save("far.las")
    assert not list(here.glob(".*part*"))


def test_rows_that_reading_left_out_are_told(here):
    with open("holes.csv", "w") as file:
        file.write("x,y,z\n0,0,0\nnan,0,0\n1,0,0\n")
    with pytest.warns(UserWarning, match="1 point of 3 left out"):
        scan = sf.read_scan("holes.csv")
    assert sf.read_scan(scan.save("out.ply")).attributes["row"].tolist() == [0, 2]
    with pytest.raises(sf.FileError, match=r"holes\.csv: point 1: is at \(nan, 0, 0\); wanted finite coordinates"):
        sf.read_scan("holes.csv", strict=True)

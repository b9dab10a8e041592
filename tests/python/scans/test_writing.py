"""Points as they are written: every format comes back, by our readers and by those of others."""

import json
import warnings

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


@pytest.mark.parametrize("suffix", [".vtp", ".glb", ".gltf"])
def test_what_is_written_for_viewers_alone_says_so_when_it_is_read(here, scan, suffix):
    """Neither reader sends to the other and no further: points have to be written as something else."""
    pytest.importorskip("pyvista" if suffix == ".vtp" else "trimesh")
    scan.save(f"out{suffix}")
    for read in (sf.read_scan, sf.read, sf.Surfels.from_mesh):
        with pytest.raises(sf.FileError, match=rf"^out\{suffix}: .*writ.*as \.ply or \.npz instead$"):
            read(f"out{suffix}")


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
    with pytest.raises(ValueError, match=rf"colors: wanted bytes \({N}, 3\), whole numbers from 0 to 255, got float64"):
        scan.save("out.ply", colors=np.full((N, 3), 0.5))
    with pytest.raises(ValueError, match=r"colors: wanted bytes .*, got bool"):
        scan.save("out.ply", colors=np.ones((N, 3), bool))
    for value in (256, -1):
        with pytest.raises(ValueError, match=rf"colors: wanted values in \[0, 255\], got {value} at index \(0, 0\)"):
            scan.save("out.ply", colors=np.full((N, 3), value))
    for columns in ("kwh", 5, np.zeros((N, 3))):
        with pytest.raises(ValueError, match=r"columns: wanted a dict of arrays by their names, got "):
            scan.save("out.ply", columns)
    for lines in ("one line", [5], 5):
        with pytest.raises(ValueError, match="comments: wanted a list of lines of text"):
            scan.save("out.ply", comments=lines)
    with pytest.raises(ValueError, match="comments: wanted lines of text, got one with a line break"):
        scan.save("out.ply", comments=["two\nlines"])
    with pytest.raises(ValueError, match="path: wanted points to write, and there are none"):
        scan[[]].save("out.ply")
    far = sf.Scan(np.array([[0.0, 0, 0], [1e12, 0, 0]]), frame=sf.read_scan(scan.save("a.las")).frame)
    with pytest.raises(sf.FileError, match="its coordinates do not fit the 32 bits"):
        far.save("far.las")
    assert not list(here.glob(".*part*"))


@pytest.mark.parametrize(
    ("suffix", "names", "said"),
    [
        (".ply", {"x": "x_2", "nx": "nx_2", "red": "red_2"}, "x as x_2, nx as nx_2, red as red_2"),
        (".csv", {"x": "x_2", "a b": "a_b", "a;b": "a_b_2"}, "x as x_2, a b as a_b, a;b as a_b_2"),
        (".las", {"x": "x_2", "Y": "Y_2", "u" * 40: "u" * 32}, f"x as x_2, Y as Y_2, {'u' * 40} as {'u' * 32}"),
        (".vtp", {"RGB": "RGB_2"}, "RGB as RGB_2"),
        (".gltf", {"kwh": "_KWH", "KWH": "_KWH_2"}, "KWH as KWH_2"),
        (".npz", {"x": "x", "red": "red", "a b": "a b"}, None),
    ],
)
def test_columns_that_have_other_names_in_the_file_are_told(here, scan, suffix, names, said):
    path = f"out{suffix}"
    columns = {name: np.arange(N) + float(k) for k, name in enumerate(names)}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        scan.save(path, columns)
    told = [] if said is None else [f"{path}: columns have other names there: {said}"]
    assert [str(warning.message) for warning in caught] == told
    if suffix == ".vtp":
        import pyvista

        there = pyvista.read(path).point_data
        assert np.array_equal(there["RGB"], scan.display_colors())
    elif suffix == ".gltf":
        there = json.loads((here / path).read_text())["meshes"][0]["primitives"][0]["attributes"]
        assert set(names.values()) <= set(there)
        return
    else:
        again = sf.read_scan(path)
        there = again.attributes
        assert np.abs(again.points - scan.points).max() <= 5e-5  # coordinates stay themselves
    for name, other in names.items():
        assert np.array_equal(there[other], columns[name]), name


@pytest.mark.parametrize("name", ["points", "normals", "colors"])
def test_columns_take_no_name_of_what_a_file_has_for_its_own(here, scan, name):
    with pytest.raises(ValueError, match=rf"^columns: {name} are what a file has for its own; wanted another name"):
        scan.save("out.npz", {name: np.ones(N)})
    with pytest.raises(ValueError, match=rf"^attributes: {name} are what a file has"):
        sf.Scan(scan.points, attributes={name: np.ones(N)}).save("out.ply")


def test_rows_that_reading_left_out_are_told(here):
    with open("holes.csv", "w") as file:
        file.write("x,y,z\n0,0,0\nnan,0,0\n1,0,0\n")
    with pytest.warns(UserWarning, match="1 point of 3 left out"):
        scan = sf.read_scan("holes.csv")
    assert sf.read_scan(scan.save("out.ply")).attributes["row"].tolist() == [0, 2]
    with pytest.raises(sf.FileError, match=r"holes\.csv: point 1: is at \(nan, 0, 0\); wanted finite coordinates"):
        sf.read_scan("holes.csv", strict=True)


def test_what_las_has_no_room_for_stands_in_extra_dimensions(here, scan):
    """Fractions of an intensity, classes above 255, and of an old format return numbers above 7 and 120 degrees."""
    fractions = np.linspace(0, 1, N)
    with pytest.warns(UserWarning, match="LAS has no room for values of classification, intensity"):
        again = sf.read_scan(scan.save("out.las", {"intensity": fractions, "classification": np.full(N, 256)}))
    assert again.attributes["intensity"] == pytest.approx(fractions, abs=0)
    assert (again.attributes["classification"] == 256).all()
    assert not {"intensity_2", "classification_2"} & again.attributes.keys()
    with pytest.warns(UserWarning, match="LAS has no room for values of intensity, classification"):
        twice = sf.read_scan(again.save("twice.laz"))
    assert twice.attributes["intensity"] == pytest.approx(fractions, abs=0)
    values = {"return_number": np.full(N, 9), "scan_angle": np.full(N, 120.0)}
    old = sf.Scan(scan.points, attributes=values, frame={**FRAME, "point_format": 1})
    with pytest.warns(UserWarning, match="LAS has no room for values of return_number, scan_angle"):
        again = sf.read_scan(old.save("old.las"))
    for name, expected in values.items():
        assert (again.attributes[name] == expected).all()


FRAME = {"offsets": np.array([635000.0, 848000, 400]), "scales": np.full(3, 1e-3), "version": "1.1"}
FRAME |= {"reference": [], "wkt": False, "gps_time_type": 0}


def test_no_column_takes_the_place_of_another(here, scan):
    """Names with blanks, of axes, of channels, and alike in the first 32 bytes, in every format."""
    long = "a very long name of more than thirty-two bytes"
    more = {"x": 1.0, "red": 2.0, "Height above ground": 3.0, f"{long} 1": 4.0, f"{long} 2": 5.0, "k_r": 6.0}
    more = {name: np.full(N, value) for name, value in more.items()} | {"k": np.full((N, 3), 7.0)}
    for suffix in (".ply", ".csv", ".las"):
        with pytest.warns(
            UserWarning, match=r": columns have other names there: x as x_2, red as red_2, .*k_r as k_2_r"
        ):
            again = sf.read_scan(scan.save(f"out{suffix}", more))
        assert np.abs(again.points - scan.points).max() < 1e-4
        found = [float(values[0]) for values in again.attributes.values() if np.ptp(values) == 0 and values[0] != 0]
        assert sorted(found) == [1, 2, 3, 4, 5, 6, 7, 7, 7]
    saved = sf.read_scan(scan.save("out.npz", {"file": np.arange(N)}))
    assert np.array_equal(saved.attributes["file"], np.arange(N))


def test_flags_and_reference_systems_behind_the_points_are_kept(here, scan):
    laspy = pytest.importorskip("laspy")
    whole = laspy.read(scan.save("first.las"))
    flags = {"withheld": 1, "overlap": 1, "synthetic": 1, "scanner_channel": 3, "user_data": 255}
    for name, most in flags.items():
        whole[name] = np.arange(N) % (most + 1)
    whole.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.vlrs.known.WktCoordinateSystemVlr('PROJCS["far"]')])
    whole.red = np.arange(N) * 131 % 65536
    whole.write("with.las")
    scan = sf.read_scan("with.las")
    assert "key_point" not in scan.attributes  # all of them 0
    scan.save("again.las")
    again = laspy.read("again.las")
    for name, most in flags.items():
        assert np.array_equal(again[name], np.arange(N) % (most + 1)), name
    assert np.array_equal(again.red, whole.red)  # all 16 bits
    assert [v.string for v in (*again.header.vlrs, *(again.evlrs or ())) if v.record_id == 2112] == ['PROJCS["far"]']


def test_small_clouds_far_off_fit(here):
    points = np.random.default_rng(0).random((1000, 3)) * 1e-4 + 0.5
    again = sf.read_scan(sf.Scan(points).save("small.las")).points
    assert np.abs(again - points).max() < 1e-4 * 1e-4 / np.sqrt(1000)


def test_rows_that_are_sorted_anew_are_told(here):
    np.savez("some.npz", points=np.random.default_rng(0).random((50, 3)))
    scan = sf.read_scan("some.npz")
    assert "row" not in sf.read_scan(scan.save("same.ply")).attributes
    back = sf.read_scan(scan[::-1].save("back.ply"))
    assert back.attributes["row"].tolist() == list(range(49, -1, -1))


@pytest.mark.parametrize("suffix", [s for s in WRITTEN if s not in (".glb", ".gltf", ".vtp")])
def test_rows_stand_beside_those_of_the_file(here, suffix):
    scan = sf.Scan(np.eye(3), attributes={"row": np.array([7, 8, 9])}, rows=np.array([0, 2, 5]))
    with pytest.warns(UserWarning, match=r"columns have other names there: row as row_2$"):
        found = sf.read_scan(scan.save("some" + suffix)).attributes
    assert (found["row"].tolist(), found["row_2"].tolist()) == ([7, 8, 9], [0, 2, 5])
    scan = sf.Scan(np.eye(3), rows=np.array([0, 2, 5]))
    with pytest.warns(UserWarning, match=r"columns have other names there: row as row_2$"):
        found = sf.read_scan(scan.save("given" + suffix, {"row": [1.0, 2.0, 3.0]})).attributes
    assert (found["row"].tolist(), found["row_2"].tolist()) == ([1, 2, 3], [0, 2, 5])


@pytest.mark.parametrize("suffix", WRITTEN)
def test_a_file_that_is_replaced_keeps_its_mode(here, scan, suffix):
    path = scan.save(f"out{suffix}")
    path.chmod(0o600)
    scan.save(path)
    assert path.stat().st_mode & 0o777 == 0o600
    assert [p.name for p in here.iterdir()] == [path.name]


def test_normals_of_gltf_have_a_length(here, scan):
    normals = scan.normals.copy()
    normals[3] = np.nan
    from surflux.meshes.gltf_container import Container

    path = scan.save("out.glb", normals=normals)
    header = Container(path)
    accessor = header.header["meshes"][0]["primitives"][0]["attributes"]["NORMAL"]
    assert np.linalg.norm(header.array(accessor, "VEC3"), axis=1) == pytest.approx(np.ones(N), abs=1e-6)


@pytest.mark.parametrize("suffix", ["las", "glb"])
def test_a_stray_does_not_round_all_others(tmp_path, suffix):
    """Of a survey whose scanner wrote 0 0 0 for one point: coordinates became whole metres."""
    points = np.random.default_rng(0).uniform([453000, 5234000, 400], [453100, 5234100, 410], (20000, 3))
    points[0] = 0
    path = tmp_path / f"survey.{suffix}"
    if suffix == "las":
        sf.Scan(points).save(path)
        found = sf.read_scan(path).points
    else:
        with pytest.warns(UserWarning, match="1 of 20000 points are moved"):  # the stray, alone
            sf.Scan(points).save(path, up=[0, 0, 1])
        trimesh = pytest.importorskip("trimesh")
        scene = trimesh.load(path)
        (name,) = scene.graph.nodes_geometry
        matrix, geometry = scene.graph[name]
        turned = scene.geometry[geometry].vertices @ matrix[:3, :3].T + matrix[:3, 3]
        found = turned @ [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    assert np.abs(found - points)[1:].max() < 1.01e-3


def test_sparse_points_of_las_are_not_rounded_to_a_part_of_their_spacing(tmp_path):
    """200 points over 200 km had steps of 1 m, 1e-4 of their spacing; half a step of 1e-4 is the most now."""
    points = np.random.default_rng(0).uniform(0, [2e5, 2e5, 10], (200, 3))
    found = sf.read_scan(sf.Scan(points).save(tmp_path / "sparse.las")).points
    assert np.abs(found - points).max() < 0.501e-4


def test_points_that_floats_of_gltf_move_are_told_of(tmp_path):
    """Points .02 apart, one of them at 3 000 001.1: floats there are .25 apart, and the next one is .1 off."""
    points = np.random.default_rng(0).uniform(0, 1, (2500, 3))
    points[0] = [3000001.1, 0, 0]
    with pytest.warns(
        UserWarning, match=r"far\.glb: 1 of 2500 points are moved by up to 0\.\d+, .* \.ply and \.npz keep"
    ):
        sf.Scan(points).save(tmp_path / "far.glb")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.Scan(points[1:]).save(tmp_path / "near.glb")


def test_coordinates_that_32_bits_do_not_hold_are_told_of(tmp_path):
    points = np.random.default_rng(0).uniform(0, 0.1, (20000, 3))
    points[0] = 1e6
    with pytest.warns(UserWarning, match=r"far\.las: coordinates are rounded to 0\.0005, for they reach over 1e\+06"):
        sf.Scan(points).save(tmp_path / "far.las")
    assert np.abs(sf.read_scan(tmp_path / "far.las").points - points).max() < 2.51e-4

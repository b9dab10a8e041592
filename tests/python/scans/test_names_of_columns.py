"""Names of columns: in any case and in every format that has names; those that other programs give."""

import warnings

import numpy as np
import pytest

import surflux as sf
from surflux._base.color import reflectance_of_colors
from surflux.points.ply_arrays import load_arrays

POINTS = np.random.default_rng(0).random((40, 3))
NAMES = ("reflectance", "Reflectance", "REFLECTANCE")


def written(path, columns):
    """A file of POINTS with columns (n,) under just these names, as other programs write it."""
    table = np.column_stack([POINTS, *columns.values()])
    names = ["X", "Y", "Z", *columns] if path.suffix != ".pcd" else ["x", "y", "z", *columns]
    if path.suffix == ".csv":
        np.savetxt(path, table, header=",".join(names), comments="", delimiter=",")
    elif path.suffix == ".ply":
        properties = "".join(f"property double {name}\n" for name in names)
        head = f"ply\nformat ascii 1.0\nelement vertex {len(table)}\n{properties}end_header"
        np.savetxt(path, table, header=head, comments="")
    elif path.suffix == ".pcd":
        many = [" ".join([one] * len(names)) for one in ("8", "F")]
        size = f"WIDTH {len(table)}\nHEIGHT 1\nPOINTS {len(table)}"
        head = f"FIELDS {' '.join(names)}\nSIZE {many[0]}\nTYPE {many[1]}\n{size}\nDATA ascii"
        np.savetxt(path, table, header=head, comments="")
    elif path.suffix == ".npz":
        np.savez(path, points=POINTS, **columns)
    else:
        sf.Scan(POINTS, attributes=columns).save(path)
    return path


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".pcd", ".npz", ".las", ".laz"])
def test_reflectance_is_known_in_any_case(tmp_path, suffix, name):
    rho = np.linspace(0.1, 0.8, 40)
    path = written(tmp_path / f"a{suffix}", {name: rho})
    np.testing.assert_allclose(sf.read(path).reflectance, np.repeat(rho[:, None], 3, axis=1), rtol=1e-12)
    scan = sf.read_scan(path)
    np.testing.assert_allclose(scan.surfels().reflectance[:, 1], rho, rtol=1e-12)
    # As the file has it, for whoever reads what is written of it.
    assert [one for one in scan.attributes if one.lower() == "reflectance"] == [name]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".pcd", ".npz", ".las"])
def test_reflectance_in_decibels_is_told_by_its_name(tmp_path, suffix, name):
    path = written(tmp_path / f"a{suffix}", {name: np.linspace(-20.0, 3.0, 40)})
    told = rf"a{suffix}: its column {name} is not used: wanted values from 0 to below 1, got -20 to 3"
    with pytest.warns(UserWarning, match=told):
        np.testing.assert_array_equal(sf.read(path).reflectance, 0.5)
    again = sf.read_scan(sf.read_scan(path).save(tmp_path / "out.las"))
    np.testing.assert_allclose(again.attributes[name], np.linspace(-20.0, 3.0, 40), rtol=1e-12)


@pytest.mark.parametrize("suffix", [".csv", ".ply", ".npz"])
@pytest.mark.parametrize("case", [str.lower, str.capitalize, str.upper])
def test_all_that_surfels_have_is_known_in_any_case(tmp_path, suffix, case):
    values = {"radius": np.full(40, 0.01)}
    for k, name in enumerate(["reflectance", "emission", "specular"]):
        values |= {f"{name}_{c}": np.full(40, 0.1 * (k + 1) + 0.01 * j) for j, c in enumerate("rgb")}
    values["exponent"] = np.full(40, 7.0)
    found = sf.read(written(tmp_path / f"a{suffix}", {case(name): of for name, of in values.items()}))
    wanted = {"radii": 0.01, "exponent": 7.0}
    wanted |= {"reflectance": [0.1, 0.11, 0.12], "emission": [0.2, 0.21, 0.22], "specular": [0.3, 0.31, 0.32]}
    for name, value in wanted.items():
        np.testing.assert_allclose(getattr(found, name), np.broadcast_to(value, getattr(found, name).shape), rtol=1e-6)


def test_areas_go_by_the_name_that_surflux_writes(tmp_path):
    """A column Area of a map is that of a lot, and may be -1 where nobody knows it."""
    assert sf.read(written(tmp_path / "a.csv", {"area": np.full(40, 0.02)})).areas[0] == 0.02
    assert sf.read(written(tmp_path / "b.csv", {"Area": np.full(40, -1.0)})).areas is None


def test_of_two_cases_the_usual_name_counts(tmp_path):
    path = written(tmp_path / "a.csv", {"Reflectance": np.full(40, 0.9), "reflectance": np.full(40, 0.2)})
    np.testing.assert_array_equal(sf.read(path).reflectance, 0.2)


def test_unknown_radii_and_those_of_thinned_points_are_dropped_in_any_case(tmp_path):
    radii = np.full(40, 1e-3)
    thinned = sf.read_scan(written(tmp_path / "a.csv", {"Radius": radii}), points=10)
    assert not thinned.attributes
    radii[3] = np.nan
    assert sf.read(written(tmp_path / "b.csv", {"Radius": radii})).radii.min() > 1e-2  # estimated of all


def test_flags_of_las_are_known_in_any_case(tmp_path):
    path = written(tmp_path / "a.csv", {"Withheld": np.arange(40) % 2, "Synthetic": np.zeros(40)})
    assert list(sf.read_scan(path).attributes) == ["withheld"]
    assert len(sf.read(path, clean=True)) == 20


@pytest.mark.parametrize("names", ["nx ny nz", "Nx Ny Nz", "normal_x normal_y normal_z", "NormalX NormalY NormalZ"])
def test_ply_files_have_normals_by_all_their_names(tmp_path, names):
    columns = dict(zip(names.split(), np.tile([0.6, 0.0, 0.8], (40, 1)).T, strict=True))
    path = written(tmp_path / "a.ply", columns)
    np.testing.assert_allclose(sf.read(path).normals, np.tile([0.6, 0.0, 0.8], (40, 1)), rtol=1e-12)


def test_ply_files_have_colours_in_any_case_and_leave_out_points_that_are_nowhere(tmp_path):
    path = written(tmp_path / "a.ply", {"Red": np.full(40, 255), "Green": np.zeros(40), "Blue": np.zeros(40)})
    text = path.read_text().splitlines()
    path.write_text("\n".join([*text[:-1], "nan" + text[-1][text[-1].index(" ") :]]) + "\n")
    with pytest.warns(UserWarning, match="1 point of 40 left out, without a finite place"):
        found = sf.read(path)
    np.testing.assert_allclose(found.reflectance, np.tile([0.98, 0.0, 0.0], (39, 1)))


@pytest.mark.parametrize("three", ["Rf Gf Bf", "rf gf bf", "R G B"])
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".pcd", ".npz"])
def test_colours_may_be_fractions(tmp_path, suffix, three):
    """As CloudCompare writes them, sRGB: the bytes over 255, to six digits."""
    colors = np.random.default_rng(1).integers(0, 256, (40, 3))
    path = written(tmp_path / f"a{suffix}", dict(zip(three.split(), np.round(colors / 255, 6).T, strict=True)))
    wanted = reflectance_of_colors(colors, 255.0)
    np.testing.assert_allclose(sf.read(path).reflectance, wanted, atol=3e-6)
    np.testing.assert_allclose(sf.read_scan(path).reflectance, wanted, atol=3e-6)


@pytest.mark.parametrize("mark", [":", "_"])
@pytest.mark.parametrize("colors", ["RGB", "RGBA", "Colors"])
@pytest.mark.parametrize("suffix", [".csv", ".ply"])
def test_three_components_of_paraview(tmp_path, suffix, colors, mark):
    rgb = np.random.default_rng(1).integers(0, 256, (40, 3))
    columns = {f"{colors}{mark}{k}": rgb[:, k] for k in range(3)}
    columns |= {f"Normals{mark}{k}": np.full(40, (0.6, 0.0, 0.8)[k]) for k in range(3)}
    path = written(tmp_path / f"a{suffix}", columns)
    if suffix == ".csv":  # all of ParaView's, who puts names into quotes
        rows = path.read_text().splitlines()[1:]
        names = [*(f"Points{mark}{k}" for k in range(3)), *columns]
        path.write_text("\n".join([",".join(f'"{name}"' for name in names), *rows]))
    scan, surfels = sf.read_scan(path), sf.read(path)
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-12)
    for found in (scan, surfels):
        np.testing.assert_allclose(found.reflectance, reflectance_of_colors(rgb, 255.0), rtol=1e-9)
        np.testing.assert_allclose(found.normals, np.tile([0.6, 0.0, 0.8], (40, 1)), rtol=1e-9)
    assert not scan.attributes


@pytest.mark.parametrize("names", ["rgb", "Red Green", "colour", "Color_1 Color_2", "Rf Gf"])
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".npz"])
def test_what_looks_like_colours_and_is_not_taken_is_told(tmp_path, suffix, names):
    path = written(tmp_path / f"a{suffix}", {name: np.arange(40.0) for name in names.split()})
    named = ", ".join(names.split())
    told = rf"a{suffix}: what looks like colours is not taken \({named}\): wanted three columns such as red"
    with pytest.warns(UserWarning, match=told):
        np.testing.assert_array_equal(sf.read(path).reflectance, 0.5)
    with pytest.warns(UserWarning, match=told) as said:
        assert sf.read_scan(path).reflectance is None
    assert {warning.filename for warning in said} == {__file__}  # and not numpy's, which stands between


@pytest.mark.parametrize("names", ["infrared NIR greenness r b", "red green blue rgb"])
def test_other_names_are_no_colours(tmp_path, names):
    path = written(tmp_path / "a.csv", {name: 1.0 + np.arange(40) for name in names.split()})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sf.read_scan(path)


@pytest.mark.parametrize("name", ["höhe", "高さ", "à"])
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".npz", ".las", ".laz"])
def test_names_are_in_any_script(tmp_path, suffix, name):
    scan = sf.Scan(POINTS, attributes={name: np.arange(40.0)})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for k in range(2):
            path = scan.save(tmp_path / f"{k}{suffix}")
            scan = sf.read_scan(path)
            assert [one for one in scan.attributes if not one.isascii()] == [name]
    if suffix == ".ply":
        assert name in load_arrays(path)["columns"]


@pytest.mark.parametrize("code", ["utf-8", "latin-1"])
@pytest.mark.parametrize("suffix", [".csv", ".ply", ".pcd"])
def test_files_of_others_name_them_in_utf_8_or_latin_1(tmp_path, suffix, code):
    path = written(tmp_path / f"a{suffix}", {"hoehe_a": np.arange(40.0)})
    path.write_bytes(path.read_bytes().replace(b"hoehe_a", "höhe_à".encode(code)))
    assert list(sf.read_scan(path).attributes) == ["höhe_à"]

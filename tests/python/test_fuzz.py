"""Any bytes: a reader gives what they say or refuses them with a FileError that names the file, and nothing else.

Seeded, so that every run is the same; script/fuzz does more of it to the readers in C++. A warning of numpy's about
arithmetic counts as a fault (pyproject.toml makes it an error), and so does asking for 4 GB or taking 20 seconds.
"""

import contextlib
import resource
import signal
import warnings

import numpy as np
import pytest

import surflux as sf
from fuzzing import damaged, damaged_scene
from scan_files import pcd, table

ASCII = """ply
format ascii 1.0
element vertex 4
property float x
property float y
property float z
property float nx
property float ny
property float nz
property uchar red
property uchar green
property uchar blue
property float radius
element face 2
property list uchar int vertex_indices
end_header
0 0 0 0 0 1 255 255 255 .1
1 0 0 0 0 1 1 2 3 .1
1 1 0 0 0 1 2 3 4 .1
0 1 0 0 0 1 3 4 5 .1
3 0 1 2
3 0 2 3
"""
OBJ = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"
SCENE = {
    "name": "room",
    "units": "m",
    "object": [
        {"shape": "box", "size": [1.0, 2.0, 1.5], "patches": 2, "walls": {"left": [0.1, 0.2, 0.3]}, "two_sided": True},
        {"shape": "room", "patches": [1, 2, 3], "patch_area": 0.5, "scale": 2.0, "rotate": [90, 0, 10], "seed": 3},
        {"shape": "sphere", "points": 42, "thin": 20, "translate": [0, 1, 2], "emission": 1.0, "reflectance": 0.7},
        {
            "shape": "blob",
            "points": 30,
            "bumps": 0.2,
            "reflectance": {"pattern": "spots", "colors": [[0.1, 0.1, 0.1], [0.3, 0.3, 0.3]], "size": 0.1, "seed": 1},
        },
        {"shape": "knot", "points": 30, "radius": 1.0, "tube": 0.2, "swelling": 0.1, "windings": [2, 3]},
        {"shape": "rectangle", "corner": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 1, 0], "points": 20},
        {"file": "cloud.ply"},
        {"file": "mesh.obj", "kind": "mesh"},
        {"file": "mesh.obj", "points": 20},
    ],
    "light": [
        {"type": "point", "position": [0, 0, 3], "intensity": 10},
        {"type": "spot", "position": [0, 0, 3], "direction": [0, 0, -1], "intensity": [1, 2, 3], "cone": 40},
        {"type": "area", "corner": [0, 0, 1], "edge_u": [1, 0, 0], "edge_v": [0, 1, 0], "exitance": 3},
        {"type": "directional", "direction": [0, 0, -1], "irradiance": 2},
        {"type": "environment", "radiance": 1.0, "up": [0, 0, 1]},
        {"type": "environment", "image": "sky.hdr"},
    ],
    "camera": {"eye": [1, 2, 3], "target": [0, 0, 0], "up": [0, 0, 1], "fov": 40},
    "solve": {
        "zeta": 0.02,
        "insert": True,
        "tolerance": 1e-4,
        "rays": 64,
        "epsilon": 0.8,
        "max_memory": 1e9,
        "seed": 0,
    },
}


@contextlib.contextmanager
def bounded(seconds=20, gigabytes=4):
    """No more of address space than there is in use and so much more, and no more time."""

    def too_long(*_):
        raise TimeoutError(f"more than {seconds} s")

    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    before = signal.signal(signal.SIGALRM, too_long)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (used + gigabytes * 2**30, hard))
        signal.alarm(seconds)
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sf.Surfels([[0, 0, 0], [1, 0, 0]], [[0, 0, 1], [0, 0, 1]], radii=0.6).save("cloud.ply")
    (tmp_path / "mesh.obj").write_text(OBJ)
    sf.write_image("sky.hdr", np.ones((4, 8, 3)))
    return tmp_path


def taken(reader, path, data, also=()):
    """Whether the reader took the bytes; if not, with a FileError that begins with the path, or one of `also`."""
    path.write_bytes(data)
    refusal = None
    with bounded(), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        try:
            reader(path.name)
        except sf.FileError as error:
            refusal = str(error)
    assert refusal is None or refusal.startswith((path.name, *also))
    return refusal is None


def counts(reader, name, seeds, runs):
    """(taken, refused) of damaged files made from each of the seeds."""
    found = [taken(reader, name, damaged(seed, k)) for seed in seeds for k in range(runs)]
    return sum(found), len(found) - sum(found)


def test_points(folder):
    patches = sf.Surfels.from_mesh("mesh.obj", patch_area=0.5)
    patches.save("patches.ply")
    plain = ASCII.replace("property float n", "property float extra_")
    seeds = [(folder / name).read_bytes() for name in ("cloud.ply", "patches.ply")]
    good, refused = counts(sf.read, folder / "a.ply", [*seeds, ASCII.encode(), plain.encode()], 150)
    assert good > 40
    assert refused > 200


def test_scans(folder):
    for kind in ("ascii", "binary", "binary_compressed"):
        seed = pcd(folder / "whole.pcd", table(20), kind).read_bytes()
        good, refused = counts(sf.read_scan, folder / "a.pcd", [seed], 200)
        assert good > 0  # NPZ has checksums
        assert refused > 20
    np.savez(folder / "whole.npz", points=np.ones((20, 3)), label=np.arange(20))
    rows = [" ".join(map(str, row)) for row in np.arange(60).reshape(10, 6)]
    text = "\n".join(rows).encode()
    for name, seed in (("a.npz", (folder / "whole.npz").read_bytes()), ("a.xyz", text), ("a.pts", b"10\n" + text)):
        good, refused = counts(sf.read_scan, folder / name, [seed], 200)
        assert good > 0  # NPZ has checksums
        assert refused > 20


def test_meshes(folder):
    for name, seed in (("a.ply", ASCII), ("a.obj", OBJ)):
        for reader in (sf.Surfels.from_mesh, lambda path: sf.Surfels.sample_mesh(path, 20)):
            good, refused = counts(reader, folder / name, [seed.encode()], 200)
            assert good > 0
            assert refused > 100


def test_solutions(folder):
    scene = sf.Scene(
        [sf.Surfels.from_mesh("mesh.obj")],
        lights=[sf.AreaLight([0, 0, 1], [0, 1, 0], [1, 0, 0], 2.0)],
        camera=sf.Camera([1, 1, 1], [0, 0, 0]),
    )
    sf.solve(scene).save("solution.ply")
    good, refused = counts(sf.load_solution, folder / "a.ply", [(folder / "solution.ply").read_bytes()], 500)
    assert good > 50
    assert refused > 200


def test_gaussians(folder):
    rng = np.random.default_rng(0)
    arrays = rng.normal(size=(3, 3)), rng.uniform(0.1, 1.0, (3, 3)), rng.normal(size=(3, 4)), rng.uniform(0, 1, 3)
    gaussians = sf.Gaussians(*arrays, rng.normal(size=(3, 4, 3)))
    for ending in (".ply", ".glb", ".gltf"):
        whole = gaussians.save(f"whole{ending}").read_bytes()
        good, refused = counts(sf.load_gaussians, folder / f"a{ending}", [whole], 300)
        assert good > 5
        assert refused > 100


def test_images(folder):
    for name in ("a.exr", "a.hdr", "a.png"):
        sf.write_image(name, np.linspace(0.0, 1.0, 180).reshape(6, 10, 3))
        whole = (folder / name).read_bytes()
        good, refused = counts(sf.read_image, folder / name, [whole], 200)
        assert good + refused == 200
        assert refused > 30


@pytest.mark.slow
def test_scene_files(folder):
    loaded = 0
    also = ("cloud.ply", "mesh.obj", "sky.hdr", "..", "/dev/zero")  # what is wrong with them is said of them
    for k in range(250):
        loaded += taken(sf.load_scene, folder / "a.toml", damaged_scene(SCENE, k), also)
    assert 20 < loaded < 230


# --- what fuzzing found, each as small as it gets --------------------------------------------------------------------


def refusal(reader, name, text):
    with open(name, "w") as file:
        file.write(text)
    with pytest.raises(sf.FileError) as caught, bounded():
        reader(name)
    return str(caught.value)


def refusal_of_object(keys):
    return refusal(sf.load_scene, "a.toml", "[[object]]\n" + keys).removeprefix("a.toml (object 1, ")


def test_scene_files_that_python_cannot_hold(folder):
    text = refusal(sf.load_scene, "a.toml", "x = " + "[" * 5000 + "]" * 5000)
    assert text == "a.toml: its tables or lists are nested too deeply"
    text = refusal(sf.load_scene, "a.toml", "x = " + "9" * 5000)
    assert text.startswith("a.toml: Exceeds the limit (4300 digits) for integer string conversion")


def test_counts_that_nothing_can_hold(folder):
    wanted = "points): wanted a whole number from 12 to 20000000, got 1000000000"
    for shape in ("sphere", "blob", "knot"):
        assert refusal_of_object(f'shape = "{shape}"\npoints = 1000000000') == wanted
    mesh = refusal_of_object('shape = "sphere"\nkind = "mesh"\npoints = 1000000000')
    assert mesh == wanted
    assert refusal_of_object('file = "mesh.obj"\npoints = 1000000000') == wanted.replace("12", "2", 1)
    text = refusal_of_object('shape = "box"\npatches = 10000')
    assert text == "patches): wanted at most 20000000 cells in all, got 600000000"


def test_a_header_that_claims_a_trillion_vertices(folder):
    for form in ("ascii", "binary_little_endian"):
        header = f"ply\nformat {form} 1.0\nelement vertex 1000000000000\nproperty float x\nend_header\n1 "
        assert "the header promises 1000000000000 of element 'vertex'" in refusal(sf.read, "a.ply", header)


def test_numbers_that_leave_the_range_of_float64_when_multiplied(folder):
    assert refusal(sf.Surfels.from_mesh, "a.obj", OBJ.replace("0 1 0", "1e308 1 0")) == (
        "a.obj: vertices: wanted coordinates up to 1e+30, got [1.e+308 1.e+000 0.e+000] in vertex 3"
    )
    wanted = "wanted values in [-1e+30, 1e+30], got 1e+308"
    for key in ("corner", "edge_u", "translate"):
        text = refusal_of_object(f'shape = "rectangle"\n{key} = [0, 1e308, 0]')
        assert text == f"{key}): {wanted} at index 1"
    assert refusal_of_object('shape = "box"\nsize = 1e308') == f"size): {wanted} at index 0"
    for key in ("scale", "radius"):
        text = refusal_of_object(f'shape = "sphere"\n{key} = 1e308')
        assert text == f"{key}): wanted values at most 1e+30, got 1e+308"
    for key in ("eye", "target", "up"):
        points = {"eye": [0, 0, 1], "target": [0, 0, 0], "up": [0, 1, 0], key: [0, 1e308, 0]}
        with pytest.raises(ValueError, match=rf"^{key}: wanted values in \[-1e\+30, 1e\+30\], got 1e\+308 at index 1"):
            sf.Camera(**points)
    with pytest.raises(
        ValueError, match=r"^points: wanted values in \[-1e\+30, 1e\+30\], got 1e\+31 at index \(0, 2\)"
    ):
        sf.Surfels([[0, 0, 1e31]], [[0, 0, 1]], radii=1.0)
    with pytest.raises(ValueError, match=r"^radii: wanted values at most 1e\+60, got 1e\+100"):
        sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1e100)


def test_meshes_of_which_nothing_is_left(folder):
    nothing = "a.obj: wanted faces with an area, got none"
    flat = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"
    with pytest.warns(UserWarning, match="1 degenerate face dropped"):
        assert refusal(sf.Surfels.from_mesh, "a.obj", flat) == nothing
    assert refusal(lambda path: sf.Surfels.sample_mesh(path, 20), "a.obj", flat) == nothing


def test_an_outline_that_goes_back_has_what_is_within(folder):
    (folder / "back.obj").write_text(OBJ.replace("f 1 2 3 4", "f 1 2 3 2 3 4"))
    (folder / "once.obj").write_text(OBJ)
    assert (
        sf.Surfels.from_mesh(folder / "back.obj").areas.sum() == sf.Surfels.from_mesh(folder / "once.obj").areas.sum()
    )


def test_keys_of_another_kind(folder):
    knot = 'shape = "knot"\n'
    assert refusal_of_object(knot + "windings = 2.0") == "windings): wanted two whole numbers, got 2.0"
    assert refusal_of_object(knot + "windings = [1, 2, 3]") == "windings): wanted two whole numbers, got [1, 2, 3]"
    text = refusal_of_object(knot + "radius = 1e9\ntube = 1")
    assert text == "tube): wanted values in [100000, 1e+13], got 1"
    text = refusal_of_object(
        'shape = "sphere"\nreflectance = { pattern = "marble", colors = [[0, 0, 0], [0, 0, 0]], size = 1e-300 }'
    )
    assert text.startswith("reflectance, size): wanted at least 9.")
    light = '[[object]]\nshape = "box"\n[[light]]\ntype = "environment"\nradiance = "sky.hdr"'
    text = refusal(sf.load_scene, "a.toml", light)
    assert text == "a.toml (light 1, radiance): wanted a number or RGB, got 'sky.hdr'; image takes a path"

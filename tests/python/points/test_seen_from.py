"""From where points without normals were seen: depth cameras, terrain, and what is neither."""

import logging
import tracemalloc
import warnings

import numpy as np
import pytest

import surflux as sf
from surflux.geometry.estimates import outward_normals
from surflux.points.layers import _thin_out_from_origin, layer_of
from surflux.points.seen_from import viewed_from
from surflux.points.terrain import normals_of_terrain


def place_of(points):
    return viewed_from(points)[1]


def hills(count=20_000, seed=0):
    """A terrain with a house on it, 100 by 80 m, far from the origin."""
    x, y = np.random.default_rng(seed).uniform([[0], [0]], [[100], [80]], (2, count))
    house = 6.0 * ((abs(x - 50) < 8) & (abs(y - 40) < 5))
    return np.transpose([x + 6e5, y + 8e5, 3 * np.sin(x / 9) + 2 * np.cos(y / 7) + house + 400])


def ball(count=8000, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def depth_image(sign, size=(160, 120)):
    """What a camera at the origin that looks along z, or back, sees of a ball of radius 1 before a wall 6 away."""
    u, v = np.meshgrid(np.linspace(-0.6, 0.6, size[0]), np.linspace(-0.45, 0.45, size[1]))
    ray = np.stack([u, v, np.full_like(u, sign)], axis=-1).reshape(-1, 3)
    middle = np.array([0.4, 0.2, 3.5 * sign])
    along, squared = ray @ middle, (ray**2).sum(axis=1)
    root = along**2 - squared * (middle @ middle - 1.0)
    with np.errstate(invalid="ignore"):
        t = np.where(root > 0, (along - np.sqrt(root)) / squared, 6.0)
    return ray * t[:, None]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_terrain_faces_upwards(tmp_path, seed, caplog):
    points = hills(seed=seed)
    np.savez(tmp_path / "hills.npz", points=points)
    with caplog.at_level(logging.INFO, "surflux"):
        read = sf.read(tmp_path / "hills.npz")
    assert (read.normals[:, 2] > 0).mean() > 0.995
    assert [r.message for r in caplog.records if "upwards" in r.message and "hills.npz" in r.message]
    # Whoever says from where has it so.
    below = sf.read(tmp_path / "hills.npz", viewpoint=[6e5 + 50, 8e5 + 40, -1e5])
    assert (below.normals[:, 2] < 0).mean() > 0.995


@pytest.mark.parametrize("seed", range(8))
def test_terrain_of_arrays_faces_upwards_as_that_of_files(seed):
    """Sloping, flat or bumpy: which way it faced was chance, and a third of the seeds had no sky, without a word."""
    random = np.random.default_rng(seed)
    xy = random.uniform(-50, 50, (3000, 2))
    slope, bumps = 0.1 * (seed % 3), 0.5 * (seed % 4)
    terrain = sf.Surfels(np.c_[xy, slope * xy[:, 0] + bumps * np.sin(xy[:, 0] / 7) + 0.02 * random.normal(size=3000)])
    assert (terrain.normals[:, 2] > 0).all()


def finer_on_floor(spacing, seed):
    """A floor 4 m wide at 7 cm with a box and a table's board on it at a finer spacing, as a scan of objects has it;
    how many points are the floor's."""
    random = np.random.default_rng(seed)

    def grid(u, v, apart):
        u, v = np.meshgrid(np.arange(*u, apart), np.arange(*v, apart))
        return np.c_[u.ravel(), v.ravel()] + random.uniform(-0.3, 0.3, (u.size, 2)) * apart

    def faces(low, high):
        for axis in range(3):
            across = [k for k in range(3) if k != axis]
            for end in (low, high):
                out = np.insert(grid(*((low[k], high[k]) for k in across), spacing), axis, end[axis], axis=1)
                yield out[(out[:, 2] > 0.0) | (axis != 2)]

    floor = grid((-2, 2), (-2, 2), 0.069)
    floor = floor[~(np.abs(floor) < 0.3).all(axis=1)]
    objects = [*faces([-0.3, -0.3, 0], [0.3, 0.3, 0.5]), *faces([0.8, -0.2, 0.6], [1.4, 0.4, 0.62])]
    points = np.vstack([np.c_[floor, np.zeros(len(floor))], *objects])
    return points + 0.0005 * random.normal(size=points.shape), len(floor)


@pytest.mark.parametrize("spacing", [0.06, 0.016, 0.01, 0.005])
@pytest.mark.parametrize("seed", range(3))
def test_a_floor_beneath_objects_sampled_finer_faces_upwards(spacing, seed):
    """Columns with the points of objects decided alone, and the floor faced down: 2 % of the sun arrived."""
    points, floor = finer_on_floor(spacing, seed)
    assert place_of(points)[2] > 100.0
    if spacing == 0.016:
        assert np.mean(sf.Surfels(points).normals[:floor, 2] > 0.0) > 0.99


@pytest.mark.parametrize("height", [50.0, 80.0, 150.0, 400.0, -60.0, -200.0])
@pytest.mark.parametrize("seed", range(4))
def test_terrain_above_the_origin_is_no_frame(height, seed):
    """In local x and y, with its elevation, it fills a cone around z as what a depth camera sees, and faced down."""
    random = np.random.default_rng(seed)
    xy = random.uniform(-40, 40, (5000 if seed % 2 else 1200, 2)) * [1.0, 0.6]
    hill = np.c_[xy, np.sin(xy[:, 0] / 9) + height]
    town = np.c_[xy, 8.0 * (np.abs(xy - [10, 5]) < [12, 8]).all(axis=1) + height]
    slope = np.c_[xy, 0.1 * xy[:, 0] + 0.05 * random.normal(size=len(xy)) + height]
    for terrain in (hill, town, slope):
        assert place_of(terrain)[2] > 1000.0


def town(walls, houses=4, seed=0, count=20_000):
    """(points of level ground 120 m wide with houses of 20 x 20 x 12 m, points of the walls of each, their normals)."""
    random = np.random.default_rng(seed)
    xy, z, sides = random.uniform(-60, 60, (count, 2)), np.zeros(count), []
    for corner in ([0, 0], [35, 35], [-35, 35], [35, -35])[:houses]:
        z[(np.abs(xy - corner) < 10).all(axis=1)] = 12.0
        along, side, axis = (
            random.uniform(-10, 10, walls),
            random.choice([-1.0, 1.0], walls),
            random.integers(0, 2, walls),
        )
        place = np.where(axis[:, None] == 0, np.c_[10 * side, along], np.c_[along, 10 * side]) + corner
        sides.append((np.c_[place, random.uniform(0, 12, walls)], side[:, None] * np.eye(3)[axis]))
    points, normals = (np.vstack(some) for some in zip(*sides, strict=True))
    return np.c_[xy, z], points, normals


@pytest.mark.parametrize(("walls", "houses"), [(3000, 1), (8000, 1), (3000, 4)])
@pytest.mark.parametrize("seed", range(2))
def test_facades_of_a_terrain_face_outwards(tmp_path, walls, houses, seed):
    """From above one cannot tell: 16 to 65 % of the walls faced outwards, and had a fifth of the sun, unsaid."""
    ground, facades, outwards = town(walls, houses, seed)
    noise = 0.01 * np.random.default_rng(seed).normal(size=(len(ground) + len(facades), 3))
    points = np.vstack([ground, facades]) + noise
    stray = [[3e5, 2e5, 900.0]]
    np.savez(tmp_path / "town.npz", points=np.vstack([points, stray]))
    for found in (sf.Surfels(points), sf.read(tmp_path / "town.npz")):
        normals = found.normals[: len(points)]
        assert np.mean(normals[: len(ground), 2] > 0.0) > 0.99
        assert np.mean(np.sum(normals[len(ground) :] * outwards, axis=1) > 0.0) > 0.97


@pytest.mark.parametrize("off", [(500, 800, 1600), (1000, 1000, 1300), (400, 200, 500), (100, 100, 300), (0, 0, 250)])
@pytest.mark.parametrize("seed", range(2))
def test_a_town_is_no_frame(off, seed):
    """Points of walls, which are one over the other, lie more evenly where they are seen from aside."""
    ground, facades, _ = town(857, 1, seed, 6000)
    assert place_of(np.vstack([ground, facades]) + off)[2] > 3000.0


@pytest.mark.parametrize("degrees", [0, 5, 10])
@pytest.mark.parametrize("noise", [0.0, 0.002, 0.01])
def test_a_wall_that_a_depth_camera_sees_is_no_terrain(degrees, noise):
    """It has one height z, too, and little of it, where the camera looks at it straight on."""
    u, v = np.meshgrid(np.linspace(-0.55, 0.55, 320), np.linspace(-0.41, 0.41, 240))
    rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3)
    away = 2.0 / (rays @ [np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    away *= 1.0 + noise * np.random.default_rng(0).normal(size=len(away))
    np.testing.assert_array_equal(place_of(rays * away[:, None]), 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_depth_camera_is_at_the_origin(tmp_path, sign):
    points = depth_image(sign)
    np.savez(tmp_path / "frame.npz", points=points)
    read = sf.read(tmp_path / "frame.npz")
    assert ((read.normals * points).sum(axis=1) < 0).mean() > 0.995


@pytest.mark.parametrize(
    "points",
    [
        ball(),
        ball() + np.array([0.0, 0.0, 5.0]),  # before the origin, but seen from both sides
        0.2 * ball() + np.array([3e5, 4e5, 100]),
        np.vstack([hills(5000), hills(5000) + np.array([0, 0, 30])]),  # a floor and a ceiling
        hills()[:, [0, 2, 1]] - np.array([6e5, 0, 0]),  # a facade
        hills(500),  # few
    ],
    ids=["ball", "ball before the origin", "ball far away", "two floors", "facade", "few"],
)
def test_bodies_and_rooms_were_seen_from_nowhere(points):
    assert place_of(points) is None


def scanned_room(seed=0):
    """What a scanner at the origin sees of a room from (-4, -3, -1.5) to (8, 5, 2), by even angles; and its normals."""
    azimuth, elevation = np.meshgrid(np.radians(np.arange(0, 360, 1.5)), np.radians(np.arange(-60, 61, 1.5)))
    cosine = np.cos(elevation)
    rays = np.stack([cosine * np.cos(azimuth), cosine * np.sin(azimuth), np.sin(elevation)], axis=-1).reshape(-1, 3)
    with np.errstate(divide="ignore"):
        walls = np.where(rays > 0, [8, 5, 2], [4, 3, 1.5]) / np.abs(rays)
    wall = np.argmin(walls, axis=1)
    noise = 1 + 1e-4 * np.random.default_rng(seed).normal(size=(len(rays), 1))
    return rays * np.min(walls, axis=1)[:, None] * noise, -np.sign(rays) * np.eye(3)[wall]


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_scanner_turned_at_the_origin(tmp_path, seed, caplog):
    points, truth = scanned_room(seed)
    np.savez(tmp_path / "room.npz", points=points)
    with caplog.at_level(logging.INFO, "surflux"):
        read = sf.read(tmp_path / "room.npz")
    edge = np.sort(np.abs(points - np.clip(points, [-3.7, -2.7, -1.2], [7.7, 4.7, 1.7])), axis=1)[:, 1] > 0
    assert np.all(np.sum(read.normals * truth, axis=1)[~edge] > 0)
    assert any("as if a scanner had turned there" in record.message for record in caplog.records)
    assert place_of(points + np.array([3, 0, 0])) is None
    assert place_of(sf.Surfels(points, truth).thinned(1500).points) is None


def test_a_scanner_that_turned_is_told_of_points_thinned_while_they_are_read(tmp_path, caplog):
    points, truth = scanned_room()
    np.savez(tmp_path / "room.npz", points=points, normals=truth)
    scan = sf.read_scan(tmp_path / "room.npz", points=1500)
    assert place_of(scan.points) is None
    assert scan.viewpoint.tolist() == [0.0, 0.0, 0.0]
    assert not [record for record in caplog.records if "face the origin" in record.message]
    np.savez(tmp_path / "room.npz", points=points)
    with caplog.at_level(logging.INFO, "surflux"):
        thinned = sf.read(tmp_path / "room.npz", points=1500)
    assert np.all(np.sum(thinned.normals * thinned.points, axis=1) < 0)
    assert [record for record in caplog.records if "room.npz: estimated normals face the origin" in record.message]
    np.savez(tmp_path / "moved.npz", points=points + np.array([3, 0, 0]))
    assert sf.read_scan(tmp_path / "moved.npz", points=1500).viewpoint is None
    assert sf.read_scan(tmp_path / "room.npz").viewpoint is None  # which the points themselves tell, see read


def test_a_scanner_at_the_origin_is_found_among_dropped_returns():
    points, _ = scanned_room()
    assert not np.any(place_of(np.vstack([points, np.zeros((len(points), 3))])))
    assert place_of(np.zeros((2000, 3))) is None
    assert place_of(np.vstack([points[:900], np.zeros((2000, 3))])) is None


def test_of_many_points_few_are_looked_at_for_their_spacing():
    """30 000 of 600 000: 5 % of their memory, and some copies."""
    points = ball(600_000)
    tracemalloc.start()
    try:
        assert not _thin_out_from_origin(points)
        assert tracemalloc.get_traced_memory()[1] < 0.5 * points.nbytes
    finally:
        tracemalloc.stop()


def test_a_plane_through_the_origin_is_a_terrain():
    """No depth is 0 for a camera there, and nothing is divided by it."""
    plane = np.random.default_rng(0).uniform(-1, 1, (3000, 3)) * [1, 1, 0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert place_of(plane)[2] > 100
        assert place_of(plane - np.array([0, 0, 1e-3]) * (np.arange(3000) % 2)[:, None])[2] > 100


@pytest.mark.scans
@pytest.mark.parametrize(
    ("file", "front"),
    [
        ("scans/autzen_trim.laz", "above"),
        ("scans/milk_color.pcd", "origin"),
        ("scans/region_growing_tutorial.pcd", "origin"),
        ("hard/rops_cloud.pcd", "origin"),
        ("scans/room_scan1.pcd", "origin"),
        ("scans/bunnyDouble.e57", None),
        ("statues/armadillo_43k.ply", None),
        ("statues/dragon_50k.ply", None),
    ],
)
def test_scans(scans, file, front):
    found = place_of(sf.read_scan(scans / file).points)
    kind = None if found is None else "above" if np.any(found) else "origin"
    assert kind == front


@pytest.mark.slow
@pytest.mark.parametrize("points", [hills(), depth_image(1.0)], ids=["terrain", "frame"])
def test_a_layer_with_normals_the_other_way_round_is_turned(tmp_path, points, caplog):
    np.savez(tmp_path / "layer.npz", points=points)
    right = sf.read(tmp_path / "layer.npz").normals
    np.savez(tmp_path / "layer.npz", points=points, normals=-right)
    assert sf.read(tmp_path / "layer.npz").normals == pytest.approx(-right)  # asked for nothing
    with caplog.at_level(logging.INFO, "surflux"):
        turned = sf.read(tmp_path / "layer.npz", orient=True).normals
    assert np.mean(np.sum(turned * right, axis=1) > 0.0) > 0.999
    assert any("its normals face away and are turned over, all of them, to face" in r.message for r in caplog.records)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("noise", [0.0, 0.005])
def test_a_ball_that_rests_on_a_floor_faces_outwards_and_the_floor_the_ball(seed, noise):
    """Through the contact the floor went on inside of the ball."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(3000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    points = np.concatenate([0.6 * d + [0, 0, 0.6], np.c_[rng.uniform(-2, 2, (8000, 2)), np.zeros(8000)]])
    points += noise * rng.normal(size=points.shape)
    truth = np.concatenate([d, np.tile([0, 0, 1.0], (8000, 1))])
    ball = np.arange(len(points)) < 3000
    for estimated in (normals_of_terrain(points), outward_normals(points)):
        right = np.sum(estimated * truth, axis=1) > 0.0
        # Twelve neighbours reach two spacings, .09: so far from the floor a point of the ball has links to it.
        assert np.mean(right[ball & (points[:, 2] > 0.09)]) > 0.97
        assert np.mean(right[~ball]) > 0.97
    beside = ~ball & (np.hypot(*points[:, :2].T) > 0.5)
    assert normals_of_terrain(points)[beside, 2].min() > 0.0


@pytest.mark.parametrize("across", [1e-10, 1e-13])
def test_points_in_a_line_are_no_layer(across):
    """Columns as wide as the points are apart are countless: they took 26 GiB."""
    random = np.random.default_rng(0)
    assert layer_of(np.c_[random.uniform(0, 1000, 5000), random.uniform(0, across, 5000), np.zeros(5000)]) is None

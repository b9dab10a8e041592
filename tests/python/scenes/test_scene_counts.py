"""load_scene(surfels=n): a scene of that many surfels, its clouds denser or sparser; and what mends a scan."""

from pathlib import Path

import numpy as np
import pytest

import surflux as sf
from surflux.scenes import shapes
from surflux.scenes.scene_file import Table, read_toml
from surflux.scenes.scene_object import open_object

DATA = Path(__file__).parents[3] / "data"
ROOM = '[[object]]\nshape = "room"\npatches = 2\n'  # 24 patches


def cloud(more):
    return f'[[object]]\nshape = "sphere"\n{more}\n'


@pytest.fixture
def load(tmp_path):
    def write_and_load(text, surfels=None):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return sf.load_scene(path, surfels=surfels)

    return write_and_load


def counts(scene):
    return [len(s) for s in scene.objects]


def test_clouds_become_denser_or_sparser_in_proportion(load):
    text = ROOM + cloud("points = 100") + cloud("points = 301\nthin = 200") + '[[object]]\nshape = "box"\n'
    text += 'kind = "surfels"\npoints = 300'
    assert counts(load(text)) == [24, 100, 200, 300]
    for wanted, found in ((324, [24, 50, 100, 150]), (924, [24, 150, 300, 450]), (325, [24, 50, 100, 151])):
        assert counts(load(text, wanted)) == found
    assert counts(load(text, 624)) == [24, 100, 200, 300]


def test_the_count_of_the_file_changes_nothing(load):
    text = ROOM + cloud("points = 162") + cloud("points = 300\nthin = 77\ntwo_sided = true")
    as_written, asked = load(text), load(text, 24 + 162 + 2 * 77)
    for one, other in zip(as_written.objects, asked.objects, strict=True):
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.radii, other.radii)


def test_a_cloud_of_a_file_is_thinned_though_nobody_asks_for_it(load, tmp_path):
    ball = shapes.sphere(500)
    ball.save(tmp_path / "ball.ply")
    text = ROOM + '[[object]]\nfile = "ball.ply"\nseed = 3\nreflectance = 0.7'
    assert counts(load(text)) == counts(load(text, 524)) == [24, 500]
    sparse = load(text, 124).objects[1]
    assert np.array_equal(sparse.points, sf.read(tmp_path / "ball.ply").thinned(100, seed=3).points)
    assert np.all(sparse.reflectance == 0.7)
    with pytest.raises(ValueError, match=r"^surfels: wanted fewer, for object 2 .* 501 .* only 500 surfels; got 525$"):
        load(text, 525)


def test_the_smallest_keep_their_fewest(load):
    text = cloud("points = 1000") + cloud("points = 13")
    assert counts(load(text, 200)) == [188, 12]  # a sphere has 12 points or more
    assert counts(load(text, 24)) == [12, 12]
    with pytest.raises(ValueError, match=r"^surfels: wanted at least 24, for this scene has no fewer; got 23$"):
        load(text, 23)


def test_counts_that_cannot_be_had(load):
    with pytest.raises(ValueError, match=r"^surfels: wanted at least 24, 24 of them patches, .* got 23$"):
        load(ROOM, 23)
    with pytest.raises(ValueError, match=r"^surfels: wanted 24, for all of this scene are patches; got 25$"):
        load(ROOM, 25)
    assert counts(load(ROOM, 24)) == [24]
    pairs = ROOM + cloud("points = 100\ntwo_sided = true")
    assert counts(load(pairs, 324)) == [24, 300]
    with pytest.raises(ValueError, match=r"^surfels: wanted one more or one less, for two-sided .*; got 325$"):
        load(pairs, 325)
    # Beside others, pairs get what comes in pairs.
    assert sum(counts(load(pairs + cloud("points = 33"), 325))) == 325
    with pytest.raises(ValueError, match="surfels: wanted a whole number from 1"):
        load(ROOM, 0)
    with pytest.raises(ValueError, match=r"surfels: wanted a whole number, got 2\.5"):
        load(ROOM, 2.5)


def test_orient_turns_what_points_inwards(load, tmp_path):
    ball = shapes.sphere(3000)
    inward = ball.points[:, 2] > 0.8
    ball.flipped(inward).save(tmp_path / "ball.ply")
    entry = '[[object]]\nfile = "ball.ply"\n'
    as_it_is, mended = load(entry).objects[0], load(entry + "orient = true").objects[0]
    assert np.array_equal(np.sum(as_it_is.points * as_it_is.normals, axis=1) < 0, inward)
    assert np.all(np.sum(mended.points * mended.normals, axis=1) > 0)
    assert mended.radii.max() <= as_it_is.radii.max()
    thinned = load(entry + "orient = true\nthin = 800").objects[0]
    assert len(thinned) == 800
    assert np.all(np.sum(thinned.points * thinned.normals, axis=1) > 0)
    # A room seen from inside: most of its surfels face inwards, and stay.
    shapes.sphere(3000).flipped(~inward).save(tmp_path / "room.ply")
    entry = '[[object]]\nfile = "room.ply"\norient = true\n'
    for rooms, side in (("true", -1), ("false", 1)):
        found = load(f"{entry}rooms = {rooms}").objects[0]
        assert np.all(side * np.sum(found.points * found.normals, axis=1) > 0)
    # What is right already stays as it is.
    ball.save(tmp_path / "ball.ply")
    entry = '[[object]]\nfile = "ball.ply"\n'
    again, same = load(entry + "orient = true").objects[0], load(entry).objects[0]
    assert np.array_equal(again.normals, same.normals)
    assert np.array_equal(again.radii, same.radii)


def test_points_of_a_file_stand_up_and_face_their_viewpoint(load, tmp_path):
    """The front half of a ball, seen along its y axis, which is up."""
    ball = shapes.sphere(4000).points
    np.savetxt(tmp_path / "cap.xyz", ball[ball[:, 1] > 0.3])
    entry = '[[object]]\nfile = "cap.xyz"\n'
    for y, side in ((50, 1), (-50, -1)):
        found = load(f"{entry}up = [0, 2, 0]\nviewpoint = [0, {y}, 0]\nscale = 2\ntranslate = [0, 0, 1]").objects[0]
        assert np.all(found.points[:, 2] > 1 + 2 * 0.3)
        assert np.all(side * np.sum((found.points - [0, 0, 1]) * found.normals, axis=1) > 0)
    # By the shortest turn: of y a quarter about x, of z none, of -z half a turn, of x a quarter about y.
    as_it_is = load(entry).objects[0].points
    x, y, z = as_it_is.T
    for up, turned in (
        ("0, 1, 0", (x, -z, y)),
        ("0, 0, 1", (x, y, z)),
        ("0, 0, -1", (x, -y, -z)),
        ("1, 0, 0", (-z, y, x)),
    ):
        assert np.array_equal(load(f"{entry}up = [{up}]").objects[0].points, np.transpose(turned))


def test_points_of_a_file_are_cleaned_before_they_are_thinned(load, tmp_path):
    """A ball, a point beyond it, and ten points of it again."""
    ball = shapes.sphere(2000).points
    np.savetxt(tmp_path / "a.xyz", np.concatenate([ball, [[0, 0, 9]], ball[:10]]))
    entry = '[[object]]\nfile = "a.xyz"\n'
    assert len(load(entry).objects[0]) == 2011
    found = load(entry + "clean = true").objects[0]
    assert np.array_equal(found.points, sf.read(tmp_path / "a.xyz", clean=True).points)
    assert len(found) == 2000
    assert load(entry + "clean = true\nthin = 1999").objects[0].points[:, 2].max() <= 1.0


@pytest.mark.scans
@pytest.mark.slow
def test_the_gallery(scans):
    scene = sf.load_scene(DATA / "gallery.toml", surfels=20_000)
    assert sum(counts(scene)) == 20_000
    hall = scene.objects[0]
    assert np.sqrt(hall.areas).max() == pytest.approx(0.25)
    assert sorted(type(light).__name__ for light in scene.lights) == ["AreaLight"] * 3 + ["SpotLight"] * 5
    plinths, statues = scene.objects[1:9], scene.objects[9:]
    for plinth, statue in zip(plinths, statues, strict=True):
        assert np.allclose(plinth.points[:, :2].min(axis=0) % 0.25, 0.0)  # whole cells of the floor
        low, high = statue.points.min(axis=0), statue.points.max(axis=0)
        assert np.all(np.abs(0.5 * (low + high) - plinth.points.mean(axis=0))[:2] < 0.3)
        assert 0.0 < low[2] - plinth.points[:, 2].max() < 0.05  # it stands, neither floating nor sunk
        assert np.all(high < [12.0, 9.0, 4.75])
    assert np.all(sf.inward_patches(statues[-1]) == 0)  # the lion
    with pytest.raises(ValueError, match=r"^surfels: wanted fewer, for object 17 .* only 341989 surfels; got 1100000$"):
        sf.load_scene(DATA / "gallery.toml", surfels=1_100_000)


@pytest.mark.scans
@pytest.mark.slow
def test_the_gallery_has_as_many_surfels_as_the_paper_says(scans):
    """Counted where clouds are read, before they are thinned and sampled, which takes seconds."""
    path = DATA / "gallery.toml"
    tables = Table(path, "", read_toml(path)).tables("object")
    assert sum(open_object(table).count for table in tables) == 351_686

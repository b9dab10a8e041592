import numpy as np
import pytest

import surflux as sf
from surflux import _core


def floor(z=0.0, **options):
    square = np.array([[0, 0, z], [1, 0, z], [1, 1, z], [0, 1, z]])
    return sf.Surfels.from_mesh((square, [[0, 1, 2, 3]]), 0.25, **options)


def disks(x=0.0, **options):
    points = np.array([[x, 0, 0], [x, 1, 0], [x, 0, 1]])
    return sf.Surfels(points, np.tile([1.0, 0, 0], (3, 1)), radii=0.8, **options)


def test_surfels_are_those_of_all_objects_in_order():
    parts = [floor(0.0, reflectance=0.2), floor(2.0, reflectance=0.3, emission=4.0)]
    s = sf.Scene(parts).surfels
    for name in ("points", "normals", "radii", "areas", "reflectance", "emission", "triangles"):
        assert (getattr(s, name) == np.concatenate([getattr(part, name) for part in parts])).all()
    assert s.triangle_surfel.tolist() == [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7]


def test_areas_of_the_whole_are_open_where_any_are():
    assert sf.Scene([floor(), disks()]).surfels.areas is None
    assert sf.Scene([floor(), disks(areas=1.0)]).surfels.areas == pytest.approx([0.25] * 4 + [1.0] * 3)


def test_the_surfels_of_a_scene_are_a_copy():
    s = floor()
    sf.Scene([s]).surfels.areas = 7.0
    assert s.areas == pytest.approx([0.25] * 4)


def test_a_scene_is_compiled_once_and_again_where_areas_were_set(monkeypatch):
    calls = []
    compile_scene = _core.compile_scene

    def counted(objects, lights, progress):
        calls.append(len(objects))
        return compile_scene(objects, lights, progress)

    monkeypatch.setattr(_core, "compile_scene", counted)
    given, missing = floor(), disks()
    scene = sf.Scene([given, missing], [sf.PointLight([0, 0, 3], 1.0)])
    core = scene._to_core()
    assert core.surfels.areas == pytest.approx([0.25] * 4 + sf.effective_areas(missing).tolist())
    assert core.object.tolist() == [0] * 4 + [1] * 3
    assert missing.areas is None
    solution = sf.solve(scene)
    solution.irradiance_at([[0.5, 0.5, 0]], [[0, 0, 1]])
    sf.solve_meshless(scene)
    sf.reference_irradiance(scene, [[0.5, 0.5, 0]], [[0, 0, 1]], samples=16)
    sf.form_factors(scene)
    assert scene._to_core() is core
    assert calls == [2]
    missing.areas = 2.0  # what the user sets later counts
    assert scene._to_core().surfels.areas[4:] == pytest.approx([2.0] * 3)
    assert calls == [2, 2]


def test_areas_set_between_two_solves_count():
    s = disks()
    scene = sf.Scene([s, floor()], [sf.PointLight([0, 0, 3], 1.0)])
    sf.solve(scene)
    for areas in (2.0, 3.0):
        s.areas = areas
        assert sf.solve(scene, insert=False).surfels.areas[: len(s)] == pytest.approx([areas] * len(s))
    s.areas = None
    assert sf.solve(scene, insert=False).surfels.areas[: len(s)] == pytest.approx(sf.effective_areas(s))


def test_every_light_reaches_the_core():
    lights = [
        sf.PointLight([0, 0, 1], 2.0),
        sf.SpotLight([0, 0, 1], [0, 0, -2], [1, 2, 3], cone=30, penumbra=4),
        sf.AreaLight([0, 0, 1], [1, 0, 0], [0, -1, 0], 3.0),
        sf.DirectionalLight([0, 3, -4], 5.0),
        sf.Environment(0.5),
        sf.Environment(np.ones((2, 4, 3)), up=(0, 1, 0)),
    ]
    assert [type(light._to_core()).__name__ for light in lights] == [type(light).__name__ for light in lights]
    scene = sf.Scene([floor()], lights)
    assert scene.lights == tuple(lights)
    scene._to_core()


def test_lights_are_plain_values():
    spot = sf.SpotLight([0, 0, 1], [0, 0, -2], 4)
    assert spot.direction == (0, 0, -1)
    assert spot.intensity == (4, 4, 4)
    assert spot == sf.SpotLight(np.array([0, 0, 1]), [0, 0, -0.5], [4, 4, 4], 45, 5.0)
    assert repr(sf.PointLight([0, 1, 2], 3)) == "PointLight(position=(0.0, 1.0, 2.0), intensity=(3.0, 3.0, 3.0))"
    assert sf.DirectionalLight([0, 3, -4], 5.0).direction == pytest.approx((0, 0.6, -0.8))


def test_environment_keeps_its_own_copy_of_an_image():
    image = np.ones((2, 4, 3), np.float32)
    sky = sf.Environment(image, up=(0, 0, 5))
    image[:] = 9
    assert (sky.image == 1).all()
    assert not sky.image.flags.writeable
    assert sky.up == (0, 0, 1)
    assert repr(sky) == "Environment(image of 4 x 2 pixels, up=(0.0, 0.0, 1.0))"
    assert repr(sf.Environment([1, 2, 3])) == "Environment(radiance=(1.0, 2.0, 3.0), up=(0.0, 0.0, 1.0))"


def test_repr_counts():
    scene = sf.Scene([floor(), disks()], [sf.Environment(1.0)], name="room")
    assert repr(scene) == "Scene('room', 2 objects, 7 surfels, 1 light)"


def test_a_camera_that_is_set_is_checked():
    scene = sf.Scene([sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0)])
    scene.camera = sf.Camera([0, 0, 1], [0, 0, 0], [0, 1, 0])
    with pytest.raises(ValueError, match="camera: wanted a Camera or None, got str"):
        scene.camera = "above"
    scene.camera = None


def test_a_name_and_options_that_are_set_are_checked():
    scene = sf.Scene([floor()], name="a floor", solve_options={"zeta": 0.1})
    for wrong in (3, None):
        with pytest.raises(ValueError, match="name: wanted text, got "):
            scene.name = wrong
    for wrong in (3, {"speed": 1}, {"zeta": -1}, {1: 2}):
        with pytest.raises(ValueError, match=r"^solve_options: "):
            scene.solve_options = wrong
    assert (scene.name, scene.solve_options) == ("a floor", {"zeta": 0.1})
    scene.name, scene.solve_options = "", None
    assert (scene.name, scene.solve_options) == ("", {})


def test_solve_options_are_a_copy():
    options = {"tolerance": 1e-3}
    scene = sf.Scene([floor()], solve_options=options)
    options["zeta"] = 1
    assert scene.solve_options == {"tolerance": 1e-3}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"speed": 3},
            r"^solve_options: speed: is not an option of solve; there is error, seconds, .*, seed$",
        ),
        ({"threads": 3}, r"^solve_options: threads: is not an option"),
        ({"seed": -1}, r"^solve_options: seed: wanted a whole number from 0"),
        ({"probes": 128}, r"^solve_options: shadow_rays: wanted at least the 128 probes, got 64$"),
        ({3: 4}, r"^solve_options: wanted a dict with names as keys"),
        ([("seed", 1)], r"^solve_options: wanted a dict"),
    ],
)
def test_solve_options_are_those_of_solve(options, message):
    with pytest.raises(ValueError, match=message):
        sf.Scene([floor()], solve_options=options)


def test_solve_options_that_are_changed_in_place_are_checked_by_solvers():
    scene = sf.Scene([floor()], [sf.Environment(1.0)])
    scene.solve_options["eror"] = 1e-4
    for solver in (sf.solve, sf.solve_meshless):
        with pytest.raises(ValueError, match=r"^solve_options: eror: is not an option of solve; there is error, "):
            solver(scene)


def test_solve_options_may_be_none_where_solve_takes_it():
    options = {"max_surfels": None, "max_memory": None, "probes": 128, "shadow_rays": 128}
    assert sf.Scene([floor()], solve_options=options).solve_options == options


def test_one_of_a_kind_is_singular():
    one = sf.Surfels([[0, 0, 0]], [[0, 0, 1]], radii=1.0, areas=2.0)
    assert repr(one) == "Surfels(1 surfel, area 2)"
    assert repr(sf.Scene([one])) == "Scene(1 object, 1 surfel, 0 lights)"
    assert repr(sf.solve(sf.Scene([one]))).startswith("Solution(1 surfel, ")

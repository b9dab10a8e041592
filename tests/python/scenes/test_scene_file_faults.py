"""What scene files say of faults in tables whose files or keys are at fault, too: the table is named, and what is
misspelt comes first."""

import pytest

import surflux as sf

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
BOX = '[[object]]\nshape = "box"\n'


@pytest.fixture
def refused(tmp_path):
    """What load_scene says of a text that it refuses, beside a mesh and a broken one."""
    (tmp_path / "triangle.obj").write_text(TRIANGLE)
    (tmp_path / "broken.obj").write_text("v 0 0 zero\n")

    def said(text):
        path = tmp_path / "scene.toml"
        path.write_text(text)
        with pytest.raises(sf.FileError) as error:
            sf.load_scene(path)
        start = f"{path} ("
        assert str(error.value).startswith(start)
        return "(" + str(error.value).removeprefix(start).replace(f"{tmp_path}/", "")

    return said


def test_a_mesh_without_kind_names_scene_and_table(refused):
    said = refused(BOX + '[[object]]\nfile = "triangle.obj"\n')
    assert said.startswith("(object 2, file): triangle.obj: has 1 face; ")
    assert 'kind = "mesh"' in said


@pytest.mark.parametrize("kind", ["", 'kind = "mesh"\n', 'kind = "surfels"\npoints = 5\n'])
def test_a_broken_file_names_scene_and_table(refused, kind):
    assert refused(f'[[object]]\nfile = "broken.obj"\n{kind}').startswith("(object 1, file): broken.obj (line 1")


def test_a_file_that_is_no_picture_names_scene_and_light(refused):
    said = refused(BOX + '[[light]]\ntype = "environment"\nimage = "triangle.obj"\n')
    assert said.startswith("(light 1, image): triangle.obj: unknown image format")


MISSPELT = [
    ('[[object]]\nfile = "triangle.obj"\nknid = "mesh"\n', "object 1, knid"),
    ('[[object]]\nfile = "triangle.obj"\nknid = "mesh"\npatch_area = 0.1\n', "object 1, knid"),
    ('[[object]]\nfile = "broken.obj"\nkind = "mesh"\nscal = 3\n', "object 1, scal"),
    ('[[object]]\nfiel = "triangle.obj"\nkind = "mesh"\n', "object 1, fiel"),
    ('[[object]]\nshap = "box"\n', "object 1, shap"),
    (BOX + '[[light]]\ntipe = "point"\nposition = [0, 0, 1]\nintensity = 1\n', "light 1, tipe"),
    (BOX + 'reflectance = { patern = "marble" }\n', "object 1, reflectance, patern"),
]


@pytest.mark.parametrize(("text", "place"), MISSPELT)
def test_a_misspelt_key_is_told_before_what_is_wrong_without_it(refused, text, place):
    assert refused(text).startswith(f"({place}): is not a key here; there is ")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('file = "triangle.obj"\npatch_area = 0.1', '(object 1, patch_area): goes with kind = "mesh", not "surfels"'),
        (
            'file = "triangle.obj"\nkind = "mesh"\npoints = 9',
            '(object 1, points): goes with kind = "surfels", not "mesh"',
        ),
        ('shape = "sphere"\npatch_area = 0.1', '(object 1, patch_area): goes with kind = "mesh", not "surfels"'),
        (
            'shape = "sphere"\nclean = true',
            "(object 1, clean): is for a file of points, of which isolated and repeated",
        ),
    ],
)
def test_a_key_of_the_other_kind_says_which(refused, text, said):
    assert refused(f"[[object]]\n{text}\n").startswith(said)


@pytest.mark.parametrize("value", ["-1", "[1, 2]", "[1, 2, -3]", '"1"', '"sky.exr"'])
def test_the_radiance_of_an_environment_is_named(refused, value):
    said = refused(BOX + f'[[light]]\ntype = "environment"\nradiance = {value}\n')
    assert said.startswith("(light 1, radiance): wanted ")


NUMBERS_AS_TEXT = [
    ('[solve]\nerror = "2%"', "(solve, error): wanted real numbers, got text ('2%'); as a number that is 0.02"),
    ('[solve]\nerror = "0.05"', "(solve, error): wanted real numbers, got text ('0.05'); as a number that is 0.05"),
    ('[solve]\nerror = "fine"', "(solve, error): wanted real numbers, got text ('fine')"),
    ('[solve]\nrays = "64"', "(solve, rays): wanted a whole number, got '64'; as a number that is 64"),
    ('[solve]\nrays = "many"', "(solve, rays): wanted a whole number, got 'many'"),
    ('size = [1, "2 m", 3]', "(object 1, size): wanted real numbers, got text ('2 m')"),
    ('rotate = [0, 0, "90"]', "(object 1, rotate): wanted real numbers, got text ('90'); as a number that is 90"),
]


@pytest.mark.parametrize(("text", "said"), NUMBERS_AS_TEXT)
def test_a_number_in_quotes_is_shown_with_the_number_that_it_is(refused, text, said):
    assert refused(f"{BOX}{text}\n") == said

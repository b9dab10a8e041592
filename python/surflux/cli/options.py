"""What the commands of `surflux` take."""

import argparse

import surflux as sf
from surflux._base.check import LARGEST
from surflux.cli.completion import SHELLS
from surflux.cli.examples import epilog
from surflux.cli.parser import Parser
from surflux.cli.solar_options import add_solar_options


def command_line(runs, cloud_limit):
    """The parser of all commands; `runs` says by name which function runs one: it becomes `run` of the options."""
    parser = Parser(prog="surflux", description="Diffuse global illumination directly on points.")
    parser.add_argument("--version", action="version", version=f"surflux {sf.__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")

    def command(name, text):
        more = {"epilog": epilog(name), "formatter_class": argparse.RawDescriptionHelpFormatter}
        sub = commands.add_parser(name, help=text, description=text, **more)
        sub.set_defaults(run=runs[name])
        _loudness_options(sub)
        return sub

    solve = command("solve", "Solve a scene file, or a point cloud or mesh under light that it is given.")
    text = "a scene (.toml), a file of points, or a mesh; with --tiles several of LAS, LAZ or COPC"
    solve.add_argument("input", metavar="SCENE|CLOUD", nargs="+", action=_Inputs, help=text)
    _mesh_option(solve)
    text = "the points of a cloud as read, with their light, as .ply, .las, .laz, .csv, .npz, .vtp, .glb or .gltf; the "
    text += "solved surfels of a scene or mesh, as .ply (default: INPUT's name + _solved.ply), or lit for viewers, as "
    text += ".glb or .gltf; the faces of a mesh with their light, as .vtp; of --tiles a folder (default: tiles_solved)"
    solve.add_argument("-o", "--output", metavar="OUT", help=text)
    text = "the files are tiles of one survey, solved one after another, each with what is around it; a run that was "
    text += "stopped goes on, and --image is a map from above"
    solve.add_argument("--tiles", action="store_true", help=text)
    text = "of --tiles: metres around each that its neighbours are taken in full (default: 150)"
    solve.add_argument("--halo", type=float, metavar="M", help=text)
    text = "of --tiles: how far points beyond are apart, over those of the tiles (default: 4)"
    solve.add_argument("--far", type=float, metavar="TIMES", help=text)
    text = "of --tiles: metres of the files' unit (default: what their coordinate reference system says)"
    solve.add_argument("--unit", type=float, metavar="M", help=text)
    text = "of a cloud: write the solved surfels, too, inserted ones among them, for surflux render and view"
    solve.add_argument("--solution", metavar="OUT.ply", help=text)
    text = "of a cloud: -o has its own colours, not those of its light"
    solve.add_argument("--albedo", action="store_true", help=text)
    text = "refuse a cloud with points that have no finite place, which are left out otherwise"
    solve.add_argument("--strict", action="store_true", help=text)
    text = "light isolated points of a cloud, too, which are left out of light and picture otherwise"
    solve.add_argument("--keep-outliers", action="store_true", help=text)
    text = "leave the points of a depth camera in the steps of its depth, where they are moved to planes otherwise"
    solve.add_argument("--keep-steps", action="store_true", help=text)
    text = (
        "take the colours of a cloud as they are, where a mean reflectance outside of .3 to .5 is put right otherwise"
    )
    solve.add_argument("--raw-colors", action="store_true", help=text)
    solve.add_argument(
        "--thin", type=int, metavar="N", help=f"keep N points of a cloud, once read (default: {cloud_limit})"
    )
    text = '"radiosity" on surfels (default), or "meshless": a smooth field, on whatever patches'
    solve.add_argument("--solver", default="radiosity", choices=("radiosity", "meshless"), help=text)
    text = "the error of the irradiance that is wanted, such as 2%%: all that trades it for seconds is chosen by that"
    solve.add_argument("--error", type=_share, metavar="E", help=text)
    text = "the best within about S seconds of solving; with --error whichever comes first"
    solve.add_argument("--seconds", type=float, metavar="S", help=text)
    solve.add_argument("--tolerance", type=float, help="relative residual of the linear solver")
    solve.add_argument("--zeta", type=float, help="what interpolation may leave, of the RMS irradiance (default: 0.02)")
    solve.add_argument("--rays", type=int, metavar="N", help="rays of a node or receiver (default: 256; meshless: 512)")
    solve.add_argument("--transport", help='"auto" (default), "pairs" or "rays"')
    text = (
        "insert surfels along borders of shadows, or solve for the given ones alone (default: as the scene file "
        "says, or insert, but not into a cloud without --ground, whose points have light of their own)"
    )
    solve.add_argument("--insert", action=argparse.BooleanOptionalAction, default=None, help=text)
    solve.add_argument("--seed", type=int, help="of everything random")
    text = "share the work out among the processes of mpirun, of which the first writes and prints"
    solve.add_argument("--mpi", action="store_true", help=text)
    text = "share the work out among the workers of a Dask cluster, by the address of its scheduler, tcp://HOST:PORT"
    solve.add_argument("--cluster", metavar="ADDRESS", help=text)
    text = "keep what is computed in FOLDER, stage by stage, and go on from what is there"
    solve.add_argument("--checkpoint", metavar="FOLDER", help=text)
    _cloud_options(solve)
    _normals_option(solve)
    text = 'of a cloud: "sun", of a clear day (default of terrain), "studio", a soft lamp behind the camera, or above '
    text += 'it in a room, and a sky (default of all others), or "sky", of radiance 1 all around'
    solve.add_argument("--light", choices=("studio", "sun", "sky"), help=text)
    text = "of a cloud or a mesh: stand it on a level square, grey, under its lowest points"
    solve.add_argument("--ground", action="store_true", help=text)
    _image_options(solve)
    text = (
        "of the picture: direct light interpolated between surfels (default), or traced to every pixel: sharp shadows"
    )
    solve.add_argument("--direct", choices=("interpolated", "traced"), help=text)
    _background_option(solve, "dark grey behind a cloud in studio light, else the sky")
    solve.add_argument("--no-image", action="store_true", help="draw no picture")
    _common_options(solve)
    solve.set_defaults(usual=solve.parse_args(["-"]))  # by whose values, the very objects, what is given is told

    area = command("area", "Effective areas of a point cloud.")
    area.add_argument("input", metavar="CLOUD")
    area.add_argument("-o", "--output", metavar="OUT.ply", help="write all of CLOUD with the areas")
    area.add_argument("--method", default="curved", help='"curved" (default) or "paper": D04 eq. 9').completed_by = (
        "curved",
        "paper",
    )
    area.add_argument("--backend", default="auto", help='"auto" (default), "cpu" or "gl"').completed_by = (
        "auto",
        "cpu",
        "gl",
    )
    area.add_argument("--kappa", type=float, help="how fast a surfel's share falls with distance (default: 3)")
    area.add_argument("--resolution", type=int, metavar="N", help="samples across a disk (default: 32)")
    area.add_argument("--epsilon", type=float, help="cosine between normals of one surface (default: 0.8)")
    _cloud_options(area)
    _common_options(area)

    check = command("check", "Find normals that point inwards, and surfaces that lie in one place.")
    check.add_argument("input", metavar="SCENE|CLOUD", help="a scene (.toml), a file of points, or a mesh")
    _mesh_option(check)
    check.add_argument("-o", "--output", metavar="OUT.ply", help="write all of CLOUD with those patches turned round")
    closed = check.add_mutually_exclusive_group()
    text = "closed surfaces that face inwards are rooms, seen from inside: right"
    closed.add_argument("--rooms", action="store_true", help=text)
    text = "closed surfaces that face inwards are bodies turned inside out: -o turns them"
    closed.add_argument("--bodies", action="store_true", help=text)
    check.add_argument("--smallest", type=int, default=20, metavar="N", help="surfels of a patch (default: 20)")
    _cloud_options(check)
    _common_options(check)

    text = "What a file holds, what solve would take for granted of it, and what to type next."
    doctor = command("doctor", text)
    doctor.add_argument("input", metavar="FILE", help="points, a mesh, a scene, a solution, a transfer or a picture")
    _cloud_options(doctor)
    _common_options(doctor)

    render = command("render", "Pictures of a solved file, or Gaussians for viewers.")
    render.add_argument("input", metavar="OUT.ply")
    _image_options(render)
    _quality_options(render)
    text = "N cameras around what it looks at: --image is a film (.mp4, .gif) then, or a pattern, frames/%%04d.png"
    render.add_argument("--turntable", type=int, metavar="N", help=text)
    _fps_option(render)
    text = "write Gaussians for viewers of Gaussian splatting; a picture then only with --image"
    render.add_argument("--gaussians", metavar="OUT.glb|OUT.ply", help=text)
    _common_options(render)

    text = "Move the lamps of a scene, or turn its environment: in a window, or to pictures, a film, files or a page."
    relight = command("relight", text)
    relight.add_argument("input", metavar="SCENE|TRANSFER", help="a scene (.toml), or what --save wrote of one")
    text = "write what is precomputed of a scene, to take in place of it; nothing else then unless it is asked for"
    relight.add_argument("--save", metavar="OUT.transfer", help=text)
    relight.add_argument("-o", "--output", metavar="OUT.ply", help="write relit surfels (frames: a pattern, %%04d.ply)")
    relight.add_argument(
        "--path",
        metavar="LIGHTS.toml",
        help="keyframes of lamps, see surflux.load_lamps (default: the scene's own lamps)",
    )
    text = "turn this environment, a lat-long image as cameras take it, row 0 towards --up, or that of the scene"
    relight.add_argument("--environment", metavar="IMAGE|scene", help=text)
    text = "turn the environment so far to begin with, counter-clockwise seen from the tip of its up"
    relight.add_argument("--turn", type=float, metavar="DEGREES", help=text)
    text = "N frames of an environment once around: --image is a film (.mp4, .gif) or a pattern, frames/%%04d.png"
    relight.add_argument("--turntable", type=int, metavar="N", help=text)
    text = "write a page in which a slider turns the environment, in any browser"
    relight.add_argument("--export", metavar="OUT.html", help=text)
    text = "write Gaussians for viewers of Gaussian splatting"
    relight.add_argument("--gaussians", metavar="OUT.glb|OUT.ply", help=text)
    text = "light of lamps: interpolated between surfels (default), or traced to every pixel, with sharp shadows"
    relight.add_argument("--direct", metavar="HOW", help=text)
    relight.add_argument("--bounces", type=_bounces, metavar="N|all", help="of light (default: all)")
    relight.add_argument("--epsilon-t", type=float, help="what transfer may be off by before it is refined")
    relight.add_argument("--rays", type=int, metavar="N", help="of a coarsest point (default: 256; lamps: 128)")
    relight.add_argument("--seed", type=int, help="of everything random")
    relight.add_argument("--screenshot", metavar="OUT.png", help="write a picture of the window instead of opening it")
    _image_options(relight, "write a film (.mp4, .gif), a pattern of pictures, frames/%%04d.png, or one picture")
    _quality_options(relight)
    _fps_option(relight)
    _common_options(relight)

    solar = command("solar", "Sun and sky on roofs, facades and ground, in kWh/m2 for every point.")
    add_solar_options(solar)
    _mesh_option(solar)
    solar.add_argument("--bounces", type=_bounces, default=3, metavar="N|all", help="of light (default: 3)")
    solar.add_argument("--size", type=_size, default=(1200, 900), metavar="WxH")
    _normals_option(solar)
    _cloud_options(solar)
    _camera_options(solar, _UP_OF_SUN)
    _common_options(solar)

    view = command("view", "Look at a scene, which is solved first, a cloud, a mesh or a solved file.")
    view.add_argument("input", metavar="FILE", help="a scene (.toml), points, a solution (.ply), or a mesh")
    view.add_argument("--screenshot", metavar="OUT.png", help="write a picture instead of opening a window")
    view.add_argument("--export", metavar="OUT.html", help="write a page that any browser shows by itself")
    view.add_argument(
        "--color",
        help="radiosity, irradiance, direct, indirect, emission, reflectance, normal, radius, area, "
        "coverage, level, object, parent, group, cut: those that there are; c goes on",
    )
    view.add_argument("--style", default="disks", help="disks (default), splats or points; s goes on").completed_by = (
        "disks",
        "splats",
        "points",
    )
    view.add_argument("--light", default="all", help="of radiosity and irradiance: all (default), direct or indirect")
    view.add_argument("--stops", type=float, default=0.0, metavar="N", help="0 shows the brightest percent white")
    view.add_argument("--level", type=int, default=0, help="of the hierarchy, for --color group: 0 is the finest")
    view.add_argument("--inserted", action="store_true", help="mark inserted surfels")
    view.add_argument("--pick", type=int, metavar="INDEX", help="the surfel to pick")
    view.add_argument("--no-solve", action="store_true", help="show a scene as it is")
    view.add_argument("--zeta", type=float, help="solve a scene with this zeta (default: the scene's)")
    _mesh_option(view)
    view.add_argument("--areas", action="store_true", help="how the area is shared out: coverage, histogram, picking")
    view.add_argument("--method", help='with --areas: make them anew, "curved" or "paper" (default: those of FILE)')
    view.add_argument("--size", type=_size, default=(800, 600), metavar="WxH")
    _cloud_options(view)
    _camera_options(view)

    command("bench", "Seconds and errors of every stage on this machine.")

    info = command("info", "What this installation is made of.")
    info.add_argument("--json", action="store_true", help="print results for programs")

    completion = command("completion", "Print a script by which a shell completes commands and options.")
    completion.add_argument("shell", choices=SHELLS)
    return parser


class _Inputs(argparse.Action):
    """One or more files: the first is `input`, all are `inputs`."""

    def __call__(self, parser, namespace, values, option_string=None):
        namespace.input, namespace.inputs = values[0], values


def _loudness_options(parser):
    loudness = parser.add_mutually_exclusive_group()
    loudness.add_argument("-q", "--quiet", action="store_true", help="no progress; warnings stay")
    text = "tell the settings, and the seconds of every stage, too"
    loudness.add_argument("-v", "--verbose", action="store_true", help=text)


def _mesh_option(parser):
    text = "take the faces of a PLY file, or its points (default: faces that are far wider than points are apart)"
    parser.add_argument("--mesh", action=argparse.BooleanOptionalAction, default=None, help=text)


def _normals_option(parser):
    text = (
        'normals of a cloud or mesh: "check" (default) turns over what faces inwards, of meshes faces wound '
        'against the others, and terrain that faces down, and says so, "keep" takes them as they are, "flip" turns all '
        "over"
    )
    parser.add_argument("--normals", choices=("check", "keep", "flip"), help=text)


def _cloud_options(parser):
    text = "where a cloud was scanned from: estimated normals point there (default: what the file says)"
    parser.add_argument("--viewpoint", type=_vector, metavar="X,Y,Z", help=text)
    text = "at most N points of a cloud, such as 500k or 2M: it is thinned while it is read, evenly"
    parser.add_argument("--points", type=_many, metavar="N", help=text)


def _common_options(parser):
    parser.add_argument("--threads", type=int, metavar="N", help="at most N threads (default: all)")
    parser.add_argument("--json", action="store_true", help="print results for programs; progress goes to stderr")


def _quality_options(parser):
    parser.add_argument(
        "--samples", type=int, default=2, metavar="N", help="subpixels of a pixel each way (default: 2)"
    )
    _background_option(parser, "the sky")
    parser.add_argument("--both-sides", action="store_true", help="show surfaces from behind, too")


def _background_option(parser, default):
    text = "what is seen where nothing is: the environment of the scene, sky, which is black where there is none, or "
    text += f"from 0, black, to 1, white, as .png shows it (default: {default})"
    parser.add_argument("--background", type=_background, metavar="sky|GREY|R,G,B", help=text)


def _fps_option(parser):
    parser.add_argument("--fps", type=float, default=25.0, help="frames of a film in a second (default: 25)")


def _image_options(parser, text="write a picture; again for more (default: next to the output, .png)"):
    parser.add_argument("--image", action="append", metavar="OUT.exr|OUT.png", help=text)
    parser.add_argument("--size", type=_size, default=(800, 600), metavar="WxH")
    parser.add_argument("--exposure", metavar="FACTOR|auto", help="of .png: factor on radiance (default: auto)")
    parser.add_argument("--stops", type=float, default=0.0, help="of .png: so many times twice as bright")
    parser.add_argument("--linear", action="store_true", help="of .png: cut highlights off instead of bending them")
    _camera_options(parser)


_UP = "what is up: in the picture, whose default camera turns with it, and for a ground, a lamp or a sun that are added"
_UP_OF_SUN = "what is up in the picture alone: the sun stands over z; objects of a scene file with another axis take up"


def _camera_options(parser, up=_UP):
    parser.add_argument("--eye", type=_vector, metavar="X,Y,Z", help="where the camera stands")
    parser.add_argument("--target", type=_vector, metavar="X,Y,Z", help="what it looks at")
    parser.add_argument(
        "--up",
        type=_direction,
        metavar="X,Y,Z",
        help=f"{up} (default: 0,0,1)",
    )
    parser.add_argument("--fov", type=float, metavar="DEGREES", help="vertical field of view, default: 45")


def _vector(text):
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"wanted three numbers x,y,z, got {text!r}") from None
    if not all(abs(part) <= LARGEST for part in (x, y, z)):  # as NaN is not, either
        raise argparse.ArgumentTypeError(f"wanted three finite numbers x,y,z up to {LARGEST:g}, got {text!r}")
    return (x, y, z)


def _direction(text):
    vector = _vector(text)
    if not any(vector):
        raise argparse.ArgumentTypeError(f"wanted a direction, of non-zero length, got {text!r}")
    return vector


def _many(text):
    """A whole number, which may end in k or M."""
    factor = {"k": 1e3, "m": 1e6}.get(text[-1:].lower(), 1.0)
    try:
        number = float(text[:-1] if factor > 1.0 else text) * factor
    except ValueError:
        number = 0.5
    if not number.is_integer():  # as inf is none, either
        raise argparse.ArgumentTypeError(f"wanted a whole number, such as 500k or 2M, got {text!r}")
    return int(number)


def _share(text):
    """A share of 1: "0.02" or "2%"."""
    try:
        value = float(text[:-1]) / 100.0 if text.endswith("%") else float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value < 1.0:
        raise argparse.ArgumentTypeError(f"wanted a share below 1, such as 2% or 0.02, got {text!r}")
    return value


def _bounces(text):
    if text == "all":
        return text
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"wanted a number or all, got {text!r}") from None


def _background(text):
    if text == "sky":
        return text
    try:
        color = tuple(float(part) for part in text.split(","))
    except ValueError:
        color = ()
    if len(color) not in (1, 3) or not all(0.0 <= value <= 1.0 for value in color):
        wanted = "wanted sky, one number from 0, black, to 1, white, or three of them, R,G,B"
        raise argparse.ArgumentTypeError(f"{wanted}, got {text!r}")
    return color * (3 // len(color))


def _size(text):
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        raise argparse.ArgumentTypeError(f"wanted WIDTHxHEIGHT, such as 800x600, got {text!r}") from None
    return (width, height)

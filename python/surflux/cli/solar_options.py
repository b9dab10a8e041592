"""What `surflux solar` takes of its own."""

import argparse
import re


def add_solar_options(parser):
    """Weather, place, classes and files; all that other commands have as well is the caller's."""
    parser.add_argument("input", metavar="CLOUD|SCENE", help="a file of points, a mesh, or a scene (.toml)")
    text = "points, of a mesh the middles of its patches, with kWh/m2 in columns of their own, .ply, .laz, .csv, ... "
    text += "(default: INPUT's name + _solar.ply)"
    parser.add_argument("-o", "--output", dest="table", metavar="OUT", help=text)
    text = "a typical year's weather, EPW, with its place"
    parser.add_argument("--epw", metavar="FILE", help=text)
    text = "degrees north and east, --place=-33.9,18.4 or 33.9S,18.4E (default: of the file's coordinate system)"
    parser.add_argument("--place", type=_place, metavar="LAT,LON", help=text)
    parser.add_argument("--year", type=int, help="all hours of a year, under clear skies")
    text = "an hour around each time, under clear skies: 2025-06-21T12:00+02:00"
    parser.add_argument("--time", nargs="+", metavar="ISO", help=text)
    text = "metres above the sea, of clear skies (default: of a file with a coordinate system, the middle of its z)"
    parser.add_argument("--altitude", type=float, metavar="M", help=text)
    text = "true north is so far clockwise from +y, seen from above (default: of the file's coordinate system, else 0)"
    parser.add_argument("--north", type=float, metavar="DEGREES", help=text)
    text = "the unit of coordinates: 0.3048 for feet (default: of the file's coordinate system, else 1)"
    parser.add_argument("--unit", type=float, metavar="METRES", help=text)
    text = "classes of points that shade, numbers or names: ground,building,3-5 (default: all but noise, 7 and 18)"
    parser.add_argument("--casters", metavar="CLASSES", help=text)
    text = "of these, those that irradiation is told of (default: all but vegetation, 3 to 5)"
    parser.add_argument("--receivers", metavar="CLASSES", help=text)
    text = "take points that stand alone, which are left out otherwise"
    parser.add_argument("--keep-outliers", action="store_true", help=text)
    text = "reflected by the ground around, and by a cloud or mesh (default: 0.2)"
    parser.add_argument("--albedo", type=float, default=0.2, help=text)
    text = "a cloud or mesh reflects what its colours or intensities say"
    parser.add_argument("--colors", action="store_true", help=text)
    parser.add_argument("--sun-step", type=float, metavar="DEGREES", help="cells of the sun's positions (default: 3)")
    parser.add_argument("--seed", type=int, help="of everything random")
    parser.add_argument("--no-sky-view", action="store_true", help="leave the column of sky-view factors out")
    parser.add_argument("--image", metavar="PNG", help="the picture (default: next to the output)")
    parser.add_argument("--no-image", action="store_true", help="draw no picture")


def _place(text):
    """(latitude, longitude) in degrees, of 47.4,8.5 or 33.9S,18.4E."""
    parts = [re.fullmatch(r"\s*(-?[\d.]+)\s*([NSEW]?)\s*", part.upper()) for part in text.split(",")]
    try:
        (latitude, north), (longitude, east) = (part.groups() for part in parts)
        found = [float(latitude), float(longitude)]
    except (AttributeError, ValueError):
        found = None
    if found is None or north not in ("", "N", "S") or east not in ("", "E", "W"):
        what = "wanted LAT,LON in degrees, such as 47.4,8.5 or 33.9S,18.4E"
        raise argparse.ArgumentTypeError(f"{what}, got {text!r}")
    for letter, value in ((north, latitude), (east, longitude)):
        if letter and value.startswith("-"):
            what = f"wanted a sign or a letter, not both, as in {value} or {value[1:]}{'S' if letter in 'NS' else 'W'}"
            raise argparse.ArgumentTypeError(f"{what}, got {text!r}")
    return (-found[0] if north == "S" else found[0], -found[1] if east == "W" else found[1])

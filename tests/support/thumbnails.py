"""Small pictures of examples of the gallery, for the README and the front page of the site.

python tests/support/thumbnails.py data [NAME ...]
"""

import os
import sys
import tempfile
from pathlib import Path

import pyvista
from PIL import Image, ImageOps

EXAMPLES = Path(__file__).parents[2] / "python" / "guide" / "examples"
NAMES = [
    "cloud_without_normals",
    "sun_over_a_day",
    "radiated_heat",
    "a_lamp_that_moves",
    "back_on_my_mesh",
    "effective_areas",
]
SIZE = (320, 220)


def thumbnail(name, path):
    """Runs an example in a folder of its own; the middle of its picture, or all of a strip or plot, in 256 colours."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        exec(compile((EXAMPLES / f"{name}.py").read_text(), name, "exec"), {"__name__": "__main__"})
        (picture,) = Path(folder).glob("*.png")
        image = Image.open(picture).convert("RGB")
        is_plot = min(image.getpixel((0, 0))) > 250
        into = ImageOps.pad if is_plot or image.width > 2 * image.height else ImageOps.fit
        image = into(image, SIZE, Image.Resampling.LANCZOS, **({"color": "white"} if into is ImageOps.pad else {}))
        image.quantize(256).save(path, optimize=True)


if __name__ == "__main__":
    pyvista.OFF_SCREEN = True
    out = Path(sys.argv[1]).resolve()
    for name in sys.argv[2:] or NAMES:
        thumbnail(name, out / f"thumb_{name}.png")

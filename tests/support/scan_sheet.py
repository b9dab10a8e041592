"""Pictures of `surflux solve FILE` for all shared scans, statues and hard clouds, on one sheet; seconds are printed,
on the clock and of all processors.

    SURFLUX_DATA=FOLDER python tests/support/scan_sheet.py sheet.png [NAME ...]

Names choose files that contain one of them. Needs matplotlib (surflux[bench]).
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FOLDERS = "scans", "statues", "hard"
SUFFIXES = ".laz", ".las", ".e57", ".pcd", ".ply"
SIZE = "480x360"


def main():
    out, names = Path(sys.argv[1]), sys.argv[2:]
    data = Path(os.environ["SURFLUX_DATA"])
    files = [f for folder in FOLDERS for f in sorted((data / folder).iterdir()) if f.suffix.lower() in SUFFIXES]
    files = [f for f in files if not names or any(name in f.name for name in names)]
    with tempfile.TemporaryDirectory() as folder:
        draw(out, [solved(f, Path(folder)) for f in files])


def solved(path, folder):
    """(name, picture or None)."""
    image = folder / f"{path.stem}.png"
    command = [sys.executable, "-m", "surflux", "solve", str(path), "-o", str(folder / f"{path.stem}_lit.ply")]
    begin, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    found = subprocess.run([*command, "--image", str(image), "--size", SIZE], capture_output=True, text=True)
    seconds, used = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    print(f"{path.name}: {seconds:.0f} s, {used:.0f} of processors", flush=True)
    notes = [line for line in found.stderr.splitlines() if " " in line.removeprefix("surflux: ")]
    print("  " + "\n  ".join(notes), flush=True)
    return path.name, image if image.exists() else None


def draw(out, found, columns=4):
    from matplotlib import image
    from matplotlib.figure import Figure

    rows = -(-len(found) // columns)
    figure = Figure((columns * 4.0, rows * 3.3), layout="constrained", dpi=75)
    for axes in figure.subplots(rows, columns, squeeze=False).flat:
        axes.axis("off")
        if found:
            name, picture = found.pop(0)
            axes.set_title(name, fontsize=8)
            if picture is not None:
                axes.imshow(image.imread(picture))
    figure.savefig(out)


if __name__ == "__main__":
    main()

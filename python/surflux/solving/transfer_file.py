"""Transfers from files."""

from __future__ import annotations

from surflux._base import check
from surflux._base.array_file import read_arrays
from surflux._base.files import file_error
from surflux._base.types import FilePath
from surflux.scenes.scene_arrays import scene_of_arrays
from surflux.solving.distant_transfer import DistantTransfer
from surflux.solving.local_transfer import LocalTransfer
from surflux.solving.sky_transfer import SkyTransfer
from surflux.solving.transfer import FILE_KIND, FILE_VERSION, Transfer

LIGHTINGS: dict[str, type[Transfer]] = {kind.lighting: kind for kind in (LocalTransfer, DistantTransfer, SkyTransfer)}


def load_transfer(path: FilePath) -> Transfer:
    """The Transfer that `Transfer.save` wrote, with its scene.

    The file is mapped into memory, checked by its checksums, and copied from there once.

    Args:
        path: str or path.

    Returns:
        LocalTransfer, DistantTransfer or SkyTransfer. `relight` and `indirect` give what they gave before, bit by bit.

    Raises:
        ValueError: path is none.
        FileError: with the path and the reason: a file of another kind or version, one that is cut off, or of which
            something was changed, and what that is.

    >>> import surflux as sf
    >>> corner = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [0, 1, 1]], [[0, 1, 2, 3], [0, 3, 5, 4]]
    >>> transfer = sf.precompute_transfer(sf.Scene([sf.Surfels.from_mesh(corner, 0.1)]))
    >>> loaded = sf.load_transfer(transfer.save("corner.transfer"))
    >>> lamp = sf.PointLight([0.5, 0.5, 0.5], 1.0)
    >>> bool((loaded.indirect(lamp) == transfer.indirect(lamp)).all())
    True
    """
    path = check.path("path", path)
    about, arrays = read_arrays(path, FILE_KIND, FILE_VERSION, "transfer")
    try:
        lighting = about["lighting"]
        if lighting not in LIGHTINGS:
            raise ValueError(f"lighting: wanted {' or '.join(map(repr, LIGHTINGS))}, got {lighting!r}")
        bounces = None if about["bounces"] is None else check.count("bounces", about["bounces"], 0)
        timings = {stage: float(seconds) for stage, seconds in dict(about["timings"]).items()}
        scene = scene_of_arrays(about["scene"], _below("scene/", arrays))
        return LIGHTINGS[lighting]._of_arrays(scene, _below(f"{lighting}/", arrays), bounces, timings)
    except (ValueError, TypeError, KeyError, AttributeError, OverflowError) as fault:
        raise file_error(path, f"its transfer is damaged ({fault})") from fault


def _below(prefix, arrays):
    return {name.removeprefix(prefix): values for name, values in arrays.items() if name.startswith(prefix)}

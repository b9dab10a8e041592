"""What is seen behind a picture: Environments, in the directions in which nothing else is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux.pictures.camera import Camera
from surflux.scenes.lights import Environment

_SHOWN_IN = ("radiance", "direct")  # layers: what comes straight from a light is direct


def environments_behind(
    background: ArrayLike | Environment, own: Iterable[Environment], name: str = "background"
) -> list[Environment]:
    """The Environments that a background stands for: a colour is a sky of that radiance, True are those of the scene.

    Raises:
        ValueError: none of these.
    """
    if isinstance(background, Environment):
        return [background]
    if isinstance(background, (bool, np.bool_)):
        return list(own) if background else []
    radiance = check.rgb(name, background)
    return [Environment(radiance)] if radiance.any() else []


def add_background(
    layers: dict[str, Any], environments: Sequence[Environment], camera: Camera, samples: int
) -> dict[str, Any]:
    """The layers of a picture, with what is seen of environments where `alpha` leaves room, subpixel by subpixel."""
    shown = [name for name in _SHOWN_IN if name in layers]
    if environments and shown:
        of = [environment._to_core() for environment in environments]
        behind = _core.environment_image(of, camera._to_core(), layers["alpha"], samples)
        layers |= {name: layers[name] + behind for name in shown}
    return layers

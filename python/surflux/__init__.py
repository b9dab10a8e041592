"""surflux: diffuse global illumination directly on points.

>>> import surflux as sf
>>> sorted(sf.__all__)[:3]
['AreaLight', 'AreaShares', 'Camera']
"""

from importlib import import_module as _import_module

from surflux._base.installation import VERSION as _VERSION
from surflux._core import Cancelled as Cancelled
from surflux._core import DeviceError as DeviceError
from surflux._core import FileError as FileError

# Where each public name lives; a room alone is that of a whole module. Modules are loaded when first asked for:
# the viewer brings pyvista along.
_HOME = {
    "AreaLight": "scenes.lights",
    "AreaShares": "geometry.areas",
    "Camera": "pictures.camera",
    "DirectionalLight": "scenes.lights",
    "DistantTransfer": "solving.distant_transfer",
    "Environment": "scenes.lights",
    "Facing": "geometry.facing",
    "FormFactorOperator": "solving.form_factor_operator",
    "Gaussians": "splats.gaussians",
    "Hierarchy": "geometry.hierarchy",
    "LampRenderer": "solving.lamp_renderer",
    "LocalTransfer": "solving.local_transfer",
    "Page": "viewing.page",
    "PhotometricLight": "scenes.photometric_light",
    "Photometry": "scenes.photometry",
    "PointLight": "scenes.lights",
    "Scan": "points.scan",
    "Scene": "scenes.scene",
    "Sky": "scenes.sky",
    "SkyPatches": "scenes.sky_patches",
    "SkyTransfer": "solving.sky_transfer",
    "SolarHours": "solving.solar_result",
    "SolarIrradiation": "solving.solar_result",
    "Solution": "solutions.solution",
    "SolvedTile": "solving.tile_result",
    "SolvedTiles": "solving.tile_result",
    "SpotLight": "scenes.lights",
    "Surfels": "points.surfels",
    "Transfer": "solving.transfer",
    "animate_environment": "solving.environment_film",
    "animate_lamps": "solving.lamp_film",
    "area_shares": "geometry.areas",
    "build_hierarchy": "geometry.hierarchy",
    "camera_path": "pictures.animation",
    "concatenate": "points.arranging",
    "convolve_harmonics": "solving.harmonics",
    "divide_patches": "points.arranging",
    "effective_areas": "geometry.areas",
    "examples": "scenes",
    "facing": "geometry.facing",
    "form_factor_operator": "solving.form_factor_operator",
    "form_factors": "solving.form_factors",
    "info": "_base.installation",
    "inward_patches": "geometry.orientation",
    "load_gaussians": "splats.gaussian_files",
    "load_lamps": "scenes.lamp_path",
    "load_operator": "solving.form_factor_operator",
    "load_scene": "scenes.scene_file",
    "load_solution": "solutions.solution_file",
    "load_transfer": "solving.transfer_file",
    "move_lamps": "viewing.lamp_viewer",
    "multiply_harmonics": "solving.harmonics",
    "precompute_transfer": "solving.precomputing",
    "read": "points.reading",
    "read_image": "pictures.images",
    "read_photometry": "scenes.photometry",
    "read_scan": "points.scan",
    "reference_irradiance": "solving.reference",
    "reference_radiance": "solving.glossy_reference",
    "rotate_harmonics": "solving.harmonics",
    "save_camera": "scenes.camera_file",
    "sky_view_factor": "solving.sky_view",
    "solar_irradiation": "solving.solar",
    "solve": "solving.radiosity",
    "solve_meshless": "solving.meshless",
    "solve_tiles": "solving.tiles",
    "spherical_harmonics": "solving.harmonics",
    "tone_map": "pictures.images",
    "turn_environment": "viewing.turn_viewer",
    "turntable": "pictures.animation",
    "view": "viewing.viewer",
    "write_image": "pictures.images",
}

_import_module("surflux._base.forks")  # which has to be there before a process forks

__version__ = _VERSION
__all__ = sorted([*_HOME, "Cancelled", "DeviceError", "FileError"])

# The core's own exceptions come without words, and tracebacks name them as users write them.
for _error in (FileError, Cancelled, DeviceError):
    _error.__module__ = "surflux"
FileError.__doc__ = """A file that cannot be read or written, an OSError: "path (place): reason".

The place is the line, byte, or table and key, where there is one.
"""
Cancelled.__doc__ = "A progress callback returned False, or Ctrl-C was pressed: the pass has stopped without a result."
DeviceError.__doc__ = "There is no OpenGL to draw with, a RuntimeError: says what was tried."


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'surflux' has no attribute {name!r}")
    room, _, module = _HOME[name].partition(".")
    home = _import_module(f"surflux.{room}.{module or name}")
    value = getattr(home, name) if module else home
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *__all__})

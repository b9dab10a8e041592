# What editors and type checkers read: __init__.py loads these names when they are first asked for.
from surflux._base.installation import info as info
from surflux._core import Cancelled as Cancelled
from surflux._core import DeviceError as DeviceError
from surflux._core import FileError as FileError
from surflux.geometry.areas import AreaShares as AreaShares
from surflux.geometry.areas import area_shares as area_shares
from surflux.geometry.areas import effective_areas as effective_areas
from surflux.geometry.hierarchy import Hierarchy as Hierarchy
from surflux.geometry.hierarchy import build_hierarchy as build_hierarchy
from surflux.geometry.orientation import inward_patches as inward_patches
from surflux.pictures.animation import camera_path as camera_path
from surflux.pictures.animation import turntable as turntable
from surflux.pictures.camera import Camera as Camera
from surflux.pictures.images import read_image as read_image
from surflux.pictures.images import tone_map as tone_map
from surflux.pictures.images import write_image as write_image
from surflux.points.arranging import concatenate as concatenate
from surflux.points.arranging import divide_patches as divide_patches
from surflux.points.reading import read as read
from surflux.points.surfels import Surfels as Surfels
from surflux.scenes.camera_file import save_camera as save_camera
from surflux.scenes.lights import AreaLight as AreaLight
from surflux.scenes.lights import DirectionalLight as DirectionalLight
from surflux.scenes.lights import Environment as Environment
from surflux.scenes.lights import PointLight as PointLight
from surflux.scenes.lights import SpotLight as SpotLight
from surflux.scenes.scene import Scene as Scene
from surflux.scenes.scene_file import load_scene as load_scene
from surflux.solutions.solution import Solution as Solution
from surflux.solutions.solution_file import load_solution as load_solution
from surflux.solving.form_factor_operator import FormFactorOperator as FormFactorOperator
from surflux.solving.form_factor_operator import form_factor_operator as form_factor_operator
from surflux.solving.form_factor_operator import load_operator as load_operator
from surflux.solving.form_factors import form_factors as form_factors
from surflux.solving.meshless import solve_meshless as solve_meshless
from surflux.solving.radiosity import solve as solve
from surflux.solving.reference import reference_irradiance as reference_irradiance
from surflux.viewing.page import Page as Page
from surflux.viewing.viewer import view as view

__version__: str
__all__: list[str]

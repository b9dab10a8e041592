"""Names that annotations share. Shapes and units stand in the docstrings of what is annotated."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from surflux import _core

Floats: TypeAlias = NDArray[np.float64]
Integer: TypeAlias = int | np.integer[Any]
Integers: TypeAlias = NDArray[np.integer[Any]]
Image: TypeAlias = NDArray[np.float32]
Vector: TypeAlias = tuple[float, float, float]  # also linear RGB
Size: TypeAlias = tuple[int, int]  # width, height
FilePath: TypeAlias = str | os.PathLike[str]
Progress: TypeAlias = bool | Callable[[int, int], object]


class SurfelsLike(Protocol):
    """Surfels, as the rooms below points see them: told by what they are compiled to, as check.surfels does."""

    _core: _core.Surfels

    @property
    def areas(self) -> Floats | None: ...
    @areas.setter
    def areas(self, values: ArrayLike | None) -> None: ...
    def __len__(self) -> int: ...


SomeSurfels = TypeVar("SomeSurfels", bound=SurfelsLike)


class _Vertices(Protocol):
    """A mesh of trimesh or Open3D."""

    @property
    def vertices(self) -> Any: ...


class _Cells(Protocol):
    """A mesh of meshio."""

    @property
    def points(self) -> Any: ...
    @property
    def cells(self) -> Any: ...


class _Faces(Protocol):
    """A mesh of pyvista."""

    @property
    def points(self) -> Any: ...
    @property
    def faces(self) -> Any: ...
    @property
    def n_cells(self) -> int: ...


class _ToMesh(Protocol):
    """A scene of trimesh."""

    def to_mesh(self) -> Any: ...


class _ToLegacy(Protocol):
    """A tensor mesh or a tensor cloud of Open3D."""

    def to_legacy(self) -> Any: ...


class _Cloud(Protocol):
    """A cloud of Open3D."""

    @property
    def points(self) -> Any: ...
    @property
    def normals(self) -> Any: ...
    @property
    def colors(self) -> Any: ...


Points: TypeAlias = ArrayLike | _Cloud | _ToLegacy
Mesh: TypeAlias = FilePath | tuple[ArrayLike, ArrayLike] | _Vertices | _Cells | _Faces | _ToMesh | _ToLegacy

"""Form factors as an operator: products without a matrix of pairs."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Self, overload

import numpy as np
from numpy.typing import ArrayLike

from surflux import _core
from surflux._base import check
from surflux._base.files import file_error, require_file, whole_file
from surflux._base.passes import stage_callback, thread_limit
from surflux._base.summary import html_table, range_text
from surflux._base.types import FilePath, Floats, Progress
from surflux.cluster.engines import shared_out
from surflux.scenes.coincidence import warn_of_layers
from surflux.scenes.scene import Scene
from surflux.solving.run import check_scene

if TYPE_CHECKING:
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import LinearOperator

FEWEST_RAYS, MOST_RAYS = 16, 1 << 20
# Two standard deviations of a share of half a hemisphere by one ray.
ERROR_OF_A_RAY = 0.98
ARRAYS = ("begin", "met", "rays", "into_backs", "areas", "scale", "escape", "absorbed")
COUNTS = ("begin", "met", "rays", "into_backs")
VERSION = 1


class FormFactorOperator:
    """Form factors K of n surfels, as `form_factor_operator` makes them: K @ x and K.T @ x for x (n,) or (n, k).

    K[i, j] is the fraction of what surfel i emits that reaches surfel j, so that K @ B is the irradiance that
    radiosities B bring to all, and K.T @ p where powers p go. A_i K_ij = A_j K_ji to rounding; rows and escape make 1.
    """

    __array_ufunc__ = None  # x @ K is ours, not numpy's
    dtype = np.dtype(np.float64)
    ndim = 2

    def __init__(self, core: _core.FormFactorOperator) -> None:
        """Not called by users: see `form_factor_operator` and `load_operator`."""
        self._core = core

    @property
    def shape(self) -> tuple[int, int]:
        """(n, n)."""
        n = len(self._core.areas)
        return n, n

    @property
    def escape(self) -> Floats:
        """(n,) the share of each row that no surfel receives: what leaves the scene and what backs absorb."""
        return self._core.escape + self._core.absorbed

    @property
    def into_backs(self) -> Floats:
        """(n,) the part of `escape` that backs absorb, or for which there is no symmetric exchange."""
        return self._core.absorbed.copy()

    @property
    def areas(self) -> Floats:
        """(n,) effective areas of the surfels, as solutions have them."""
        return self._core.areas.copy()

    @property
    def rays(self) -> int:
        """How many each surfel shot."""
        return int(self._core.rays.min(initial=MOST_RAYS))

    @property
    def error(self) -> float:
        """What a surfel sends to any set of others is within it with 95 % probability or more, for patches."""
        return ERROR_OF_A_RAY / math.sqrt(self.rays)

    @property
    def T(self) -> _Transposed:
        """The transposed operator, for products alone."""
        return _Transposed(self)

    def __matmul__(self, x: ArrayLike) -> Floats:
        return self._product(x, False)

    def __rmatmul__(self, x: ArrayLike) -> Floats:
        return self._product(np.transpose(x), True).T

    def _product(self, x, transposed):
        x = self._rows(x)
        return self._core.product(x.reshape(len(x), -1), transposed).reshape(x.shape)

    def _rows(self, x):
        """x (n,) or (n, k), checked."""
        x = _as_numbers("x", x)
        n = self.shape[0]
        if x.ndim not in (1, 2) or x.shape[0] != n:
            raise ValueError(f"x: wanted shape ({n},) or ({n}, k), got {x.shape}")
        return x

    def standard_error(self, x: ArrayLike) -> Floats:
        """Standard error of K @ x for x (n,) or (n, k), in the shape of x, by the variance of independent rays.

        Rays are spread evenly, so that of x over many surfels the error is less: 1.4 to 3.3 times in rooms and between
        plates. Of x over few it may be more than it says: where no ray met any of them the variance is unknown, and 0.

        Raises:
            ValueError: x of another shape.
        """
        x = self._rows(x)
        if x.ndim == 1:
            return np.sqrt(self._core.variance(x))
        errors = np.empty_like(x)
        for column, values in enumerate(x.T):
            errors[:, column] = np.sqrt(self._core.variance(np.ascontiguousarray(values)))
        return errors

    @overload
    def to_scipy(self, sparse: Literal[False] = False) -> LinearOperator: ...
    @overload
    def to_scipy(self, sparse: Literal[True]) -> csr_array: ...
    def to_scipy(self, sparse: bool = False) -> LinearOperator | csr_array:
        """The operator for scipy's solvers: a scipy.sparse.linalg.LinearOperator.

        Args:
            sparse: True gives a scipy.sparse.csr_array of up to 2 n rays entries, 12 bytes each: some thousand surfels
                to some hundred thousand.

        Raises:
            ImportError: without scipy.
        """
        check.flag("sparse", sparse)
        return self._to_csr() if sparse else self._to_linear_operator()

    def _to_linear_operator(self):
        from scipy.sparse.linalg import LinearOperator

        there, back = self.__matmul__, self.T.__matmul__
        return LinearOperator(self.shape, matvec=there, rmatvec=back, matmat=there, rmatmat=back, dtype=self.dtype)

    def _to_csr(self):
        from scipy.sparse import csr_array

        core = self._core
        counts = csr_array((np.ones(len(core.met)), core.met, core.begin.astype(np.int64)), shape=self.shape)
        counts = (counts + counts.T).tocsr()
        counts.sum_duplicates()
        row, column = np.repeat(np.arange(self.shape[0]), np.diff(counts.indptr)), counts.indices
        density = core.rays / core.areas
        counts.data *= core.scale[row] * core.scale[column] / (density[row] + density[column]) / core.areas[row]
        return counts

    def save(self, path: FilePath) -> Path:
        """Writes the operator as a .npz file, which `load_operator` reads; the file appears whole or not at all.

        Returns:
            The pathlib.Path that was written.

        Raises:
            ValueError: a path with another suffix.
            FileError: the file cannot be written.
        """
        path = Path(check.path("path", path))
        if path.suffix.lower() != ".npz":
            raise ValueError(f"path: wanted a name ending in .npz, got {str(path)!r}")
        with whole_file(path) as file:
            np.savez(file, form_factor_operator=VERSION, **self._arrays())
        return path

    def _arrays(self):
        return {name: getattr(self._core, name) for name in ARRAYS}

    def __reduce__(self) -> tuple[Any, ...]:
        return _from_arrays, ({name: array.copy() for name, array in self._arrays().items()},)

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self  # nothing of it changes

    def __repr__(self) -> str:
        n = self.shape[0]
        return f"FormFactorOperator({check.counted(n, 'surfel')}, {self.rays} rays each, error {self.error:.2g})"

    def _repr_html_(self) -> str:
        rows = [("surfels", str(self.shape[0])), ("rays each", str(self.rays)), ("error", f"{self.error:.2g}")]
        if self.shape[0] > 0:
            rows.append(("escape", range_text(self.escape)))
        return html_table("FormFactorOperator", rows)


class _Transposed:
    """K.T, which only multiplies."""

    __array_ufunc__ = None

    def __init__(self, operator):
        self.T: FormFactorOperator = operator

    @property
    def shape(self) -> tuple[int, int]:
        return self.T.shape

    def __matmul__(self, x: ArrayLike) -> Floats:
        return self.T._product(x, True)

    def __rmatmul__(self, x: ArrayLike) -> Floats:
        return self.T._product(np.transpose(x), False).T


@shared_out
def form_factor_operator(
    scene: Scene,
    *,
    error: float | None = None,
    rays: int = 256,
    seed: int = 0,
    cluster: Any = None,
    threads: int | None = None,
    progress: Progress = False,
) -> FormFactorOperator:
    """Form factors between all surfels of a scene, any number of them, as an operator: K @ x, K.T @ x.

    What `form_factors` is for 20 000 surfels and less, by rays alone: `rays` over the hemisphere of each surfel, of
    which every end is kept, 4 bytes each. Rays of i that meet j and rays of j that meet i estimate the same exchange,
    and count together, by their variances; a symmetric diagonal scaling (Knight, Ruiz and Ucar 2014) closes the rows.
    So a uniform furnace is exact, and a small receiver has the rays of all that see it.

    A product costs one step for each ray: .1 s for 100 000 surfels with 256 rays each. An equation like
    B = E + rho K B is best solved by scipy with `to_scipy()`.

    Args:
        scene: Scene; its lights do not matter.
        error: .001 to .5, what a surfel sends to any set of others is to be within, with 95 % probability, for
            patches; None takes `rays` as they are. Costs rays in proportion to its inverse square.
        rays: least number for each surfel, at least 16; powers of 2 spread evenest.
        seed, cluster, threads, progress: see `solve`.

    Returns:
        FormFactorOperator.

    Raises:
        ValueError: an argument out of range, by name; more rays than there is memory for.
        Cancelled: the callback returned False.

    >>> import numpy as np
    >>> import surflux as sf
    >>> corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    >>> floor_and_ceiling = sf.Surfels.from_mesh((corners, [[0, 1, 2, 3], [7, 6, 5, 4]]), patch_area=0.01)
    >>> K = sf.form_factor_operator(sf.Scene([floor_and_ceiling]), rays=1024)
    >>> on_the_ceiling = np.arange(200) >= 100
    >>> print(f"{(K @ on_the_ceiling)[:100].mean():.2f}")  # opposite faces of a cube: .1998
    0.20
    """
    check_scene(scene)
    rays = check.count("rays", rays, FEWEST_RAYS, MOST_RAYS)
    if error is not None:
        error = check.number("error", error, 1e-3, 0.5)
        rays = max(rays, 1 << math.ceil(math.log2((ERROR_OF_A_RAY / error) ** 2)))
    seed = check.seed("seed", seed)
    with thread_limit(threads):
        scene._to_core(progress=progress)
        warn_of_layers(scene)
        with stage_callback(progress) as callback:
            return cluster.call(_program, scene, {"rays": rays, "seed": seed}, callback)


def _program(core, options, team, progress):
    """What each process of a cluster runs."""
    return FormFactorOperator(_core.form_factor_operator(core, **options, progress=progress, team=team))


def load_operator(path: FilePath) -> FormFactorOperator:
    """The FormFactorOperator that `FormFactorOperator.save` wrote.

    Raises:
        ValueError: path is none.
        FileError: with the path and the reason.

    >>> import surflux as sf
    >>> floor = sf.Surfels.from_mesh(([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]]), patch_area=0.25)
    >>> path = sf.form_factor_operator(sf.Scene([floor])).save("floor.npz")
    >>> sf.load_operator(path).escape
    array([1., 1., 1., 1.])
    """
    path = check.path("path", path)
    require_file(path)
    try:
        if Path(path).is_file() and not zipfile.is_zipfile(path):
            raise file_error(path, "holds no form factor operator, or no whole one")
        with np.load(path, allow_pickle=False) as file:
            if "form_factor_operator" not in file:
                raise file_error(path, "holds no form factor operator")
            if file["form_factor_operator"] != VERSION:
                raise file_error(path, "holds a form factor operator of another version of surflux")
            arrays = {name: file[name] for name in ARRAYS}
        for name in COUNTS:
            if arrays[name].dtype.kind != "u":
                raise TypeError(f"{name}: wanted counts")
        return _from_arrays(arrays)
    except OSError as fault:
        raise fault if isinstance(fault, _core.FileError) else file_error(path, fault.strerror or str(fault)) from fault
    except Exception as fault:  # numpy and zipfile raise a dozen kinds of what was changed
        raise file_error(path, f"its form factor operator is damaged ({fault})") from fault


def _from_arrays(arrays):
    return FormFactorOperator(_core.FormFactorOperator(**arrays))


def _as_numbers(name, x):
    x = check.numeric(name, np.asarray(x, float) if np.asarray(x).dtype == bool else x)
    return check.all_finite(name, np.ascontiguousarray(x, np.float64))

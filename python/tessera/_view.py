"""The viewer in a notebook: a page of its own, with the surface inside."""
from __future__ import annotations

import base64
import html
import json
import pathlib
import typing

import numpy as np
import numpy.typing as npt

from ._errors import UsageError
from ._mesh import mesh_of
from ._options import Path

if typing.TYPE_CHECKING:
    from ._triangulation import Triangulation

# Built from web/src/embedded.ts.
PAGE = pathlib.Path(__file__).with_name("viewer.html")


class View:
    """A page that draws a surface, from Triangulation.view(). Notebooks embed it."""

    def __init__(self, page: str, height: int):
        self._page, self._height = page, height

    def save(self, path: Path) -> None:
        """Writes the page as a file for any browser; it needs no other file, and no network."""
        pathlib.Path(path).write_text(self._page, encoding="utf-8")

    def _repr_html_(self) -> str:
        # Sandboxed: the page may run its scripts, and touch nothing of the notebook.
        return (f'<iframe sandbox="allow-scripts" style="width:100%;height:{self._height}px;border:0" '
                f'srcdoc="{html.escape(self._page)}"></iframe>')

    def __repr__(self) -> str:
        return f"<tessera.View: {len(self._page)} bytes of HTML; view.save('surface.html') writes them>"


def view_of(t: Triangulation, height: int, max_triangles: int) -> View:
    """Does what Triangulation.view() says."""
    if not PAGE.is_file():
        raise UsageError("this installation of tessera has no viewer: its build left out the target tessera_viewer")
    if t.dim == 2 and t.n_cells > max_triangles:
        raise too_many(t.n_cells, max_triangles)
    mesh = mesh_of(list(t), t.dim)
    points, triangles = mesh.points, mesh.cells
    if t.dim == 2:
        points = np.column_stack([points, mesh.attributes.get("z", np.zeros(len(points)))])
    else:
        triangles = hull(mesh.cells)
        if len(triangles) > max_triangles:
            raise too_many(len(triangles), max_triangles)
        used, rows = np.unique(triangles, return_inverse=True)
        points, triangles = points[used], rows.reshape(-1, 3)
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.ones(3))
    middle = (low + high) / 2  # 32 bits are enough for what is left
    given = {"low": (low - middle).tolist(), "high": (high - middle).tolist(), "unit": "",
             "places": encoded((points - middle).astype("<f4")), "rows": encoded(triangles.astype("<u4"))}
    # No text can end the element that holds it.
    text = json.dumps(given).replace("<", "\\u003c")
    return View(PAGE.read_text(encoding="utf-8").replace(">GIVEN<", f">{text}<", 1), height)


def hull(cells: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Returns the facets that only one of the tetrahedra has."""
    facets = np.sort(np.concatenate([np.delete(cells, corner, axis=1) for corner in range(4)]), axis=1)
    different, count = np.unique(facets, axis=0, return_counts=True)
    return different[count == 1]


def too_many(count: int, max_triangles: int) -> UsageError:
    return UsageError(f"the surface has {count} triangles, and view() draws at most {max_triangles}: give a larger max_triangles, "
                      "or use the viewer of a daemon, which draws results of any size")


def encoded(array: npt.NDArray[typing.Any]) -> str:
    return base64.b64encode(array.tobytes()).decode()

"""Uses an installed wheel, in a system that has no library of Tessera's and no GDAL: see try-wheel.sh."""
import pathlib
import platform
import time

begin = time.perf_counter()
import tessera  # noqa: E402

imported = time.perf_counter() - begin

import numpy as np  # noqa: E402

points = np.random.default_rng(1).random((20_000, 3))
t = tessera.triangulate(points, max_points_per_tile=3000, threads=2)
assert len(t) > 3
assert t.verify().cells == t.n_cells
assert len(tessera.Delaunay(points).simplices) == t.n_cells
lattice = np.stack(np.meshgrid(*[np.arange(8.0)] * 3), axis=-1).reshape(-1, 3)
assert tessera.triangulate(lattice, max_points_per_tile=60).digest == tessera.triangulate(lattice).digest
assert tessera.from_arrow(t).n_cells == t.n_cells
folder = pathlib.Path("/tmp/made")
folder.mkdir()
t.export(folder / "mesh.ply")
try:
    tessera.triangulate(points, dim=2).dem(folder / "heights.tif", res=0.1)
except tessera.Error as error:
    assert "need GDAL" in str(error), error
else:
    raise AssertionError("there is no GDAL here")
print(f"Python {platform.python_version()}, glibc {platform.libc_ver()[1]}, NumPy {np.__version__}: "
      f"{t.n_cells} cells, import tessera {imported * 1000:.1f} ms")

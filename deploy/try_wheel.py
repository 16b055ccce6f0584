"""Uses an installed wheel, in a system that has no library of Tessera's: see try-wheel.sh.

    try_wheel.py            there is no GDAL, either
    try_wheel.py gdal       there is one, of any version
"""
import pathlib
import platform
import sqlite3
import sys
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
folder = pathlib.Path("/tmp") / f"made-{time.time_ns()}"
folder.mkdir()
t.export(folder / "mesh.ply")
terrain = tessera.triangulate(points[:1000], dim=2, crs="EPSG:2154")
if sys.argv[1:] == ["gdal"]:
    terrain.dem(folder / "heights.tif", res=0.1)
    terrain.contours(folder / "lines.gpkg", interval=0.25)
    lines = sqlite3.connect(folder / "lines.gpkg")
    assert lines.execute("select count(*) from contours").fetchone() == (len(terrain.contours(interval=0.25)),)
    assert lines.execute("select organization_coordsys_id from gpkg_contents join gpkg_spatial_ref_sys using (srs_id)").fetchone() == (2154,)
else:
    try:
        terrain.dem(folder / "heights.tif", res=0.1)
    except tessera.Error as error:
        assert "need GDAL" in str(error), error
    else:
        raise AssertionError("there is no GDAL here")
print(f"Python {platform.python_version()}, glibc {platform.libc_ver()[1]}, NumPy {np.__version__}: "
      f"{t.n_cells} cells, import tessera {imported * 1000:.1f} ms")

#!/usr/bin/python3
"""Draws docs/density.png: the density of the bundled LiDAR block, as colours.

    scripts/draw_density.py TESSERA docs/density.png
"""
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from osgeo import gdal

# From dark blue over red to yellow: equal steps of the density's logarithm.
COLOURS = np.array([[8, 8, 40], [70, 20, 110], [160, 45, 100], [230, 95, 50], [250, 175, 40], [252, 250, 170]], float)


def main(tessera, target):
    gdal.UseExceptions()
    block = sorted(map(str, (pathlib.Path(__file__).parent.parent / "data/ign").glob("*.la[sz]")))
    with tempfile.TemporaryDirectory() as folder:
        grid = pathlib.Path(folder) / "density.tif"
        subprocess.run([tessera, "density", *block, "--dim", "2", "--res", "0.5", "-o", grid, "--quiet"], check=True)
        density = gdal.Open(str(grid)).ReadAsArray().repeat(2, axis=0).repeat(2, axis=1)
    low, high = np.percentile(density[density > 0], [1, 99.8])
    place = np.clip(np.log(np.maximum(density, low) / low) / np.log(high / low), 0, 1) * (len(COLOURS) - 1)
    bands = [np.interp(place, np.arange(len(COLOURS)), COLOURS[:, band]).astype(np.uint8) for band in range(3)]
    # Fewer colours make a small file.
    memory = gdal.GetDriverByName("MEM").Create("", density.shape[1], density.shape[0], 3, gdal.GDT_Byte)
    for band in range(3):
        memory.GetRasterBand(band + 1).WriteArray(bands[band] // 8 * 8 + 4)
    gdal.GetDriverByName("PNG").CreateCopy(target, memory, options=["ZLEVEL=9"])
    pathlib.Path(target + ".aux.xml").unlink(missing_ok=True)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])

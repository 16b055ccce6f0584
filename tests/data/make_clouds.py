#!/usr/bin/python3
"""Makes clouds/ anew from the files that its README names.  make_clouds.py POINTS LAZ_PERF TWINS

POINTS: the folder of the originals. LAZ_PERF: cpp/test/raw-sets of hobuinc/laz-perf. TWINS: ign_crop_duplicate.laz, and what POINTS has no
twin of, decoded by npm's laz-perf 0.0.7. What manifest.json says of a compressed file is of its uncompressed twin: nothing here was decoded by Tessera."""
import hashlib
import json
import os
import shutil
import sys

import numpy as np

import cut_cloud

CLOUDS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "clouds")

# Whole files, with the twin that tells what is in them: the file itself where it is not compressed.
WHOLE = {
    **{f"ign_{tile}.laz": f"ign_{tile}.las" for tile in ("77050_627755", "77050_627760", "77055_627755", "77055_627760")},
    "ign_crop_duplicate.laz": "ign_crop_duplicate.las",
    "autzen_trim.laz": "autzen_trim.las",
    "ellipsoid.copc.laz": "ellipsoid.copc.las",
    "laz_conformance/pdrf6-1.4.laz": "laz_conformance/pdrf6-1.4.las",
    "laz_conformance/pdrf7-v4-1.4.laz": "laz_conformance/pdrf7-v4-1.4.las",
    "laz_conformance/pdrf6-1.4.las": "laz_conformance/pdrf6-1.4.las",
    "laz_conformance/pdrf7-v4-1.4.las": "laz_conformance/pdrf7-v4-1.4.las",
    "laz_perf/point10.las.laz": "laz_perf/point10.las",
    "laz_perf/point-color.las.laz": "laz_perf/point-color.las",
    "laz_perf/point-color.las": "laz_perf/point-color.las",
    "laz_perf/extrabytes.laz": "laz_perf/extrabytes.las",
    "pdal_epsg_4326.las": "pdal_epsg_4326.las",
    "pdal_mvk_thin.las": "pdal_mvk_thin.las",
    "liblas_certainty3d.las": "liblas_certainty3d.las",
}

# Cut files: from what, how much (see cut_cloud.py), twin.
CUT = {
    "lone_star_begin.laz": ("lone_star.laz", 3, "lone_star.las"),
    "lone_star_part.copc.laz": ("lone_star.copc.laz", 1_200_000, "lone_star.copc.las"),
    "lion_takanawa_part.copc.laz": ("lion_takanawa.copc.laz", 700_000, "lion_takanawa.copc.las"),
    "ign_77050_627755_begin.las": ("ign_77050_627755.las", 4000, None),
    "ign_77050_627755_begin.bin": ("ign_77050_627755.bin", 4000, None),
    "pdal_hexbin_crop_begin.las": ("pdal_hexbin_crop.las", 4000, None),
    "laspy_grid_begin.las": ("laspy_grid.las", 4520, None),
    "csf_sample_begin.ply": ("csf_sample.ply", 10000, None),
    "isprs_CSite2_begin.ply": ("isprs_CSite2.ply", 20000, None),
    "velodyne_400_begin.csv": ("velodyne_400.csv", 5000, None),
    "cities_begin.csv": ("cities.csv", 8000, None),
    "cities_begin.bin2": ("cities.bin2", 8000, None),
    "galaxy_20k_begin.bin": ("galaxy_20k.bin", 8000, None),
}


def source(name):
    points, laz_perf, twins = sys.argv[1:]
    for path in (os.path.join(points, name), os.path.join(laz_perf, name.removeprefix("laz_perf/")), os.path.join(twins, name)):
        if os.path.exists(path):
            return path
    sys.exit(f"{name} is in none of {points}, {laz_perf}, {twins}")


def read(path):
    with open(path, "rb") as file:
        return file.read()


def sha256(array):
    return hashlib.sha256(np.ascontiguousarray(array).tobytes()).hexdigest()


def las_facts(las, records):
    return {"points": len(records), "format": las.format, "record_bytes": las.record_bytes,
            "xyz_sha256": sha256(las.coordinates(records)), "records_sha256": sha256(records)}


def coordinates(path):
    """Of a file that is not LAS: what Python's and NumPy's own parsers make of it."""
    data = read(path)
    if path.endswith((".csv", ".xyz")):
        lines = data.decode().replace(",", " ").splitlines()
        rows = [[float(word) for word in line.split()] for line in lines[path.endswith(".csv") :]]
        return np.array([row[:2] + [0] if path.endswith("cities_begin.csv") else row[:3] for row in rows])
    if b"format ascii" in data[:20]:
        words = data[data.index(b"end_header\n") + 11 :].split()
        return np.array([float(word) for word in words[:12]]).reshape(4, 3)
    kind = "<f8" if b"property double x" in data[:300] else "<f4"
    return np.frombuffer(data[data.index(b"end_header\n") + 11 :], kind).reshape(-1, 3).astype("<f8")


def main():
    manifest = {}
    for name, twin in WHOLE.items():
        os.makedirs(os.path.dirname(os.path.join(CLOUDS, name)), exist_ok=True)
        shutil.copyfile(source(name), os.path.join(CLOUDS, name))
        las = cut_cloud.Las(read(source(twin)))
        manifest[name] = las_facts(las, las.records())
    for name, (original, count, twin) in CUT.items():
        part = cut_cloud.cut(source(original), count, twin and source(twin))
        with open(os.path.join(CLOUDS, name), "wb") as file:
            file.write(part)
        if name.endswith((".bin", ".bin2")):
            continue
        if not name.endswith((".las", ".laz")):
            manifest[name] = {}
            continue
        las, whole = cut_cloud.Las(part), cut_cloud.Las(read(source(twin or original)))
        copc = ".copc." in name
        records = cut_cloud.copc_records(cut_cloud.Las(read(source(original))), whole, count) if copc else whole.records(0, las.points)
        manifest[name] = las_facts(whole, records)
    # A cloud of the kind that has neither names nor commas, with columns behind x, y and z.
    with open(os.path.join(CLOUDS, "velodyne_400_begin.csv"), encoding="ascii") as csv:
        rows = csv.read().splitlines()[1:2001]
    with open(os.path.join(CLOUDS, "velodyne_400_begin.xyz"), "w", encoding="ascii") as xyz:
        xyz.writelines(" ".join(row.replace(",", " ").split()) + "\n" for row in rows)
    for name in (*(name for name, facts in manifest.items() if not facts), "velodyne_400_begin.xyz", "pdal_mesh.ply"):
        xyz = coordinates(os.path.join(CLOUDS, name))
        manifest[name] = {"points": len(xyz), "xyz_sha256": sha256(xyz)}
    with open(os.path.join(CLOUDS, "manifest.json"), "w", encoding="ascii") as file:
        json.dump(dict(sorted(manifest.items())), file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main()

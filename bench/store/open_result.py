"""What opening a result costs others: processor seconds and peak memory of VTK or ParaView.

    /usr/bin/python3 open_result.py MASTER...                                        in Debian's VTK (python3-vtk9)
    pvpython open_result.py MASTER...                                                in ParaView
    /usr/bin/python3 open_result.py --make build/release/src/apps/tessera 150 1.5M   makes a result of so many tiles and
                                                                                     points of made-up terrain, first
MASTER: out/triangulation.pvtu, or any file of that kind; .vtkhdf and .hdf of format 1 as well. ParaView also gathers the
range of every array, as its window shows them. Each file is opened by a process of its own.
"""
import pathlib
import resource
import subprocess
import sys
import tempfile
import time


def open_in_paraview(path):
    from paraview.simple import OpenDataFile

    def read():
        reader = OpenDataFile(path)
        reader.UpdatePipeline()
        return reader.GetDataInformation()

    return "ParaView", read


def open_in_vtk(path):
    from vtkmodules.vtkIOHDF import vtkHDFReader
    from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader
    kinds = {".pvtu": vtkXMLPUnstructuredGridReader, ".vtu": vtkXMLUnstructuredGridReader}
    reader = kinds.get(pathlib.Path(path).suffix, vtkHDFReader)()

    def read():
        reader.SetFileName(path)
        reader.Update()
        return reader.GetOutput()

    return "VTK", read


def measure(path):
    try:
        program, read = open_in_paraview(path)
    except ImportError:
        program, read = open_in_vtk(path)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss  # of the program itself
    processor, wall = time.process_time(), time.monotonic()
    grid = read()
    processor, wall = time.process_time() - processor, time.monotonic() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"{program} {path}: {grid.GetNumberOfCells()} cells, processor {processor:.2f} s, wall {wall:.2f} s, "
          f"peak {peak // 1024} MiB, of these {(peak - before) // 1024} MiB for the file", flush=True)


def make(tessera, tiles, points, folder):
    cloud = str(folder / "cloud.npy")
    subprocess.run([tessera, "generate", "terrain", "-n", points, "-o", cloud, "--quiet"], check=True)
    out = folder / "out"
    subprocess.run([tessera, "triangulate", cloud, "-o", str(out), "--tiles", tiles, "--quiet"], check=True)
    size = sum(file.stat().st_size for file in out.rglob("*") if file.is_file())
    print(f"{tiles} tiles, {points} points: {size / 1e6:.1f} MB", flush=True)
    return str(out / "triangulation.pvtu")


def main():
    if len(sys.argv) == 2:
        return measure(sys.argv[1])
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        masters = [make(*sys.argv[2:5], pathlib.Path(folder))] if sys.argv[1] == "--make" else sys.argv[1:]
        for master in masters:
            subprocess.run([sys.executable or "pvpython", __file__, master], check=True)


main()

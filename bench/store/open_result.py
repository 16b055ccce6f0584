"""What opening a result costs others: processor seconds and peak memory of VTK or ParaView.

    /usr/bin/python3 open_result.py MASTER...                                        in Debian's VTK (python3-vtk9)
    xvfb-run -a pvpython --force-offscreen-rendering open_result.py MASTER...        in ParaView, up to the picture
    /usr/bin/python3 open_result.py --make build/release/src/front/apps/tessera 150 1.65M DIR
                                                              makes results of made-up terrain to open: DIR/out of so many
                                                              tiles and points, and DIR/plain.vtu, its cells in one file

MASTER: out/triangulation.pvtu, or any file of that kind. ParaView also gathers the
range of every array, as its window shows them, and then draws: the outline, as a window does that was told so for large data;
the surface; and a slice. Each file is opened by a process of its own. Processor seconds on a machine that does other things, too, are too
many by a third and more: repeat, and take the least.
"""
import pathlib
import resource
import subprocess
import sys
import time


class Laps:
    """Prints what each step took."""
    def __init__(self):
        self.before = self.peak()
        self.start()

    def start(self):
        self.processor, self.wall = time.process_time(), time.monotonic()

    @staticmethod
    def peak():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024

    def lap(self, what):
        processor, wall = time.process_time() - self.processor, time.monotonic() - self.wall
        print(f"  {what:<28} processor {processor:6.2f} s, wall {wall:6.2f} s, peak {self.peak()} MiB, of these "
              f"{self.peak() - self.before} MiB for the file", flush=True)
        self.start()


def open_in_paraview(path):
    import paraview.simple as pv
    view = pv.GetActiveViewOrCreate("RenderView")
    pv.Render(view)  # a window is open already
    laps = Laps()
    reader = pv.OpenDataFile(path)
    reader.UpdatePipeline()
    laps.lap("read")
    cells = reader.GetDataInformation().GetNumberOfCells()
    laps.lap(f"ranges of {cells} cells")
    shown = pv.Show(reader, view)

    def draw(what):
        view.ResetCamera(False)
        pv.Render(view)
        laps.lap(what)

    shown.Representation = "Outline"
    draw("picture of the outline")
    shown.Representation = "Surface"
    draw("picture of the surface")
    pv.Render(view)
    laps.lap("the same again")
    pv.Hide(reader, view)
    pv.Show(pv.Slice(Input=reader), view)
    draw("picture of a slice")


def open_in_vtk(path):
    from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader
    kinds = {".pvtu": vtkXMLPUnstructuredGridReader, ".vtu": vtkXMLUnstructuredGridReader}
    reader = kinds[pathlib.Path(path).suffix]()
    laps = Laps()
    reader.SetFileName(path)
    reader.Update()
    laps.lap(f"read {reader.GetOutput().GetNumberOfCells()} cells")


def measure(path):
    try:
        import paraview
    except ImportError:
        print(f"VTK, {path}", flush=True)
        return open_in_vtk(path)
    print(f"ParaView {paraview.__version__}, {path}", flush=True)
    return open_in_paraview(path)


def make(tessera, tiles, points, folder):
    cloud, out, plain = (str(pathlib.Path(folder) / name) for name in ("cloud.npy", "out", "plain.vtu"))
    subprocess.run([tessera, "generate", "terrain", "-n", points, "-o", cloud, "--quiet"], check=True)
    subprocess.run([tessera, "triangulate", cloud, "-o", out, "--tiles", tiles, "--quiet"], check=True)
    subprocess.run([tessera, "export", out, "-o", plain, "--quiet"], check=True)
    size = sum(file.stat().st_size for file in pathlib.Path(out).rglob("*") if file.is_file())
    print(f"{tiles} tiles, {points} points: {size / 1e6:.1f} MB; {plain}: {pathlib.Path(plain).stat().st_size / 1e6:.1f} MB")


def main():
    if len(sys.argv) == 6 and sys.argv[1] == "--make":
        return make(*sys.argv[2:])
    if len(sys.argv) == 2:
        return measure(sys.argv[1])
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    # pvpython says that it is a vtkpython, which need not be installed.
    own = [sys.executable] if pathlib.Path(sys.executable).is_file() else ["pvpython", "--force-offscreen-rendering"]
    for master in sys.argv[1:]:
        subprocess.run([*own, __file__, master], check=True)


main()

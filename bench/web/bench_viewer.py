"""How fast the viewer draws a surface that turns, in Chromium by software alone:

    TESSERAD=... TESSERA=... bench/web/bench_viewer.py [--points 10M] [--seconds 10] [--data FOLDER]

Made-up terrain is triangulated and prepared by a daemon of its own; with --data what it made is kept, and found again. Then the camera
turns, a step a frame, as keys turn it. Prints frames a second, and the processor time that Chromium takes for one: on a machine that
others use, too, the second is what counts. Others' use is told as the load."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "tests/web"), str(ROOT / "tests/daemon")]
os.environ.setdefault("SCREENSHOTS", tempfile.gettempdir())
os.environ.setdefault("IGN", str(ROOT / "data/ign"))

import browser  # noqa: E402
import daemon  # noqa: E402

TURN = """const [seconds, done] = arguments, canvas = document.querySelector('.stage canvas'), took = [];
    const begin = performance.now(), frames = Number(canvas.dataset.frames);
    let last = begin;
    const step = now => {
      took.push(now - last);
      last = now;
      canvas.dispatchEvent(new KeyboardEvent('keydown', {code: 'ArrowLeft', key: 'ArrowLeft', shiftKey: true, bubbles: true, cancelable: true}));
      if (now - begin < 1000 * seconds) return requestAnimationFrame(step);
      done({frames: Number(canvas.dataset.frames) - frames, seconds: (performance.now() - begin) / 1000, took: took.slice(1),
            triangles: Number(canvas.dataset.triangles), calls: Number(canvas.dataset.calls), pixels: [canvas.width, canvas.height]});
    };
    requestAnimationFrame(step);"""


def processor_seconds(root):
    """Of a process and all below it."""
    parents, used, tick = {}, {}, os.sysconf("SC_CLK_TCK")
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        pid = int(stat.parent.name)
        parents[pid], used[pid] = int(fields[1]), (int(fields[11]) + int(fields[12])) / tick
    def is_below(pid):
        while pid and pid != root:
            pid = parents.get(pid)
        return pid == root
    return sum(seconds for pid, seconds in used.items() if is_below(pid))


def prepare(folder, running, points):
    if running.request("GET", "/v1/triangulations/terrain")[0] != 200:
        cloud = folder / "inputs/terrain.las"
        cloud.parent.mkdir(exist_ok=True)
        subprocess.run([os.environ["TESSERA"], "generate", "terrain", "-n", points, "-o", cloud, "--quiet"], check=True)
        run(running, "triangulate", {"inputs": ["terrain.las"], "dim": 2, "output": "terrain"})
        cloud.unlink()
    if running.request("GET", "/v1/triangulations/terrain/3dtiles/tileset.json")[0] != 200:
        run(running, "export", {"triangulation": "terrain", "output": "3dtiles", "format": "3dtiles"})


def run(running, process, inputs):
    job = running.request("POST", f"/v1/processes/{process}/execution", {"inputs": inputs})[2]
    done = running.wait(job["jobID"])
    assert done["status"] == "successful", done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", default="10M")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--data", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = options.data or pathlib.Path(made)
        folder.mkdir(exist_ok=True)
        (folder / "inputs").mkdir(exist_ok=True)
        running = daemon.Daemon(folder / "data", inputs=folder / "inputs")
        seen = browser.Browser()
        try:
            prepare(folder, running, options.points)
            seen.open(f"{running.url}#token={running.token}")
            seen.until_text("Live", ".connection")
            seen.go("#/view/terrain")
            seen.until("return document.querySelector('.stage canvas')?.dataset.loaded === 'true'")
            root = seen.driver.service.process.pid
            seen.driver.execute_async_script(TURN, 3)  # until it knows how fine it can draw
            before = processor_seconds(root)
            told = seen.driver.execute_async_script(TURN, options.seconds)
            used = processor_seconds(root) - before
            seen.until("return document.querySelector('.stage canvas').dataset.loaded === 'true'")
            took = sorted(told["took"])
            print(json.dumps({"points": options.points, "frames_per_s": round(told["frames"] / told["seconds"], 1),
                              "ms_median": round(took[len(took) // 2], 1), "ms_95": round(took[len(took) * 95 // 100], 1),
                              "processor_ms_per_frame": round(1000 * used / told["frames"], 1), "triangles": told["triangles"],
                              "draw_calls": told["calls"], "pixels": told["pixels"], "processors": os.cpu_count(),
                              "load": round(os.getloadavg()[0], 1)}))
        finally:
            seen.quit()
            running.end()


if __name__ == "__main__":
    main()

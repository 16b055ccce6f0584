"""Runs the program: its events of progress, its sentences, its end. Knows nothing of QGIS."""
import json
import queue
import shutil
import signal
import subprocess
import threading

ERROR = "tessera: "  # begins sentences about what is wrong
PATIENCE_S = 60  # how long the program may take to remove what it has begun


class Failed(Exception):
    """The program's sentence about what is wrong."""


class Canceled(Exception):
    """The work was given up by the user."""


class Listener:
    """What wants to know of a run. Each function is called by the thread that called run()."""

    def progress(self, fraction, phase):
        """`fraction` of the work of this phase is done, 0 to 1."""

    def said(self, line):
        """The program has said this beside its results: a note or a warning."""

    def canceled(self):
        return False


def find_program(setting):
    """The program that the setting names, or that of the PATH."""
    program = shutil.which(setting or "tessera")
    if program is None:
        named = f"the program '{setting}' that the settings name" if setting else "the program 'tessera'"
        raise Failed(f"{named} is not found. Install Tessera, or name the program in Settings > Options > Processing > "
                     "Providers > Tessera")
    return program


def event_of(line):
    """The event of a line; None if it has none."""
    try:
        event = json.loads(line)
    except ValueError:
        return None
    return event if isinstance(event, dict) else None


def ended(status, events, said):
    """Raises what is wrong about a run that has ended."""
    if status == 0:
        return
    errors = [event["message"] for event in events if event.get("event") == "error" and "message" in event]
    if errors:
        raise Failed(errors[-1])
    if status < 0:
        raise Failed(f"the program was ended by the signal {signal.Signals(-status).name}")
    raise Failed(said[-1] if said else f"the program ended with the status {status}, and said nothing")


def run(words, listener):
    """Runs the program with these words and returns its events but those of progress. Raises Failed or Canceled."""
    process = subprocess.Popen([str(word) for word in words], text=True, encoding="utf-8", errors="replace", stdin=subprocess.DEVNULL,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    lines = queue.Queue()
    readers = [threading.Thread(target=read_lines, args=(pipe, lines), daemon=True) for pipe in (process.stdout, process.stderr)]
    for reader in readers:
        reader.start()
    events, said, open_pipes, stopped = [], [], 2, False
    try:
        while open_pipes > 0:
            if listener.canceled() and not stopped:
                stopped = True
                stop(process)
            try:
                pipe, line = lines.get(timeout=0.2)
            except queue.Empty:
                continue
            if line is None:
                open_pipes -= 1
            else:
                take(line.rstrip("\n"), pipe is process.stdout, listener, events, said)
        status = process.wait()
    finally:
        if process.poll() is None:
            stop(process)
        for reader in readers:
            reader.join()
        process.stdout.close()
        process.stderr.close()
    if stopped:
        raise Canceled
    ended(status, events, said)
    return events


def read_lines(pipe, lines):
    for line in pipe:
        lines.put((pipe, line))
    lines.put((pipe, None))


def take(line, is_result, listener, events, said):
    event = event_of(line) if is_result else None
    if event is None and line.startswith(ERROR):
        said.append(line.removeprefix(ERROR))  # told when the program has failed
    elif event is None:
        listener.said(line)
    elif event.get("event") == "progress":
        fraction = event.get("fraction")
        listener.progress(fraction if isinstance(fraction, (int, float)) else 0, str(event.get("phase", "")))
    else:
        events.append(event)


def stop(process):
    """Asks the program to end, so that it removes what it has begun, and waits for that."""
    process.send_signal(signal.SIGTERM)
    try:
        process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()

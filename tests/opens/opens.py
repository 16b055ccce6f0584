"""Which files a program opens, by strace."""
import os
import pathlib
import re
import shutil
import subprocess
import unittest

CALL = re.compile(r'^(?:\d+ +)?(\w+)\((.*)$')
PATH = re.compile(r'"((?:[^"\\]|\\.)*)"')
OPENING = {"open", "openat", "openat2", "creat", "execve", "connect"}
# The loader's, the C library's, and what tells a process of itself and its machine.
SYSTEM = ("/lib/", "/lib64/", "/usr/lib/", "/etc/ld.so.cache", "/etc/ld.so.preload", "/usr/share/proj/", "/usr/share/gdal/", "/etc/gdal/gdalrc",
          "/proc/self/", "/proc/meminfo", "/proc/cpuinfo", "/proc/stat", "/proc/mounts", "/proc/sys/", "/sys/", "/dev/urandom",
          "/dev/null", "/etc/localtime", "/usr/share/zoneinfo/")


def need_strace():
    """Skips where the kernel lets nobody look."""
    if shutil.which("strace") is None:
        raise AssertionError("strace is missing: deploy/install-deps.sh test installs it")
    tried = subprocess.run(["strace", "-o", "/dev/null", "true"], capture_output=True, text=True)
    if tried.returncode != 0:
        raise unittest.SkipTest(f"nobody may watch a process here (ptrace is refused): {tried.stderr.strip()}")


def calls(text):
    """The calls in what strace wrote: (name, path); of a socket the whole address."""
    for line in text.splitlines():
        found = CALL.match(line)
        if not found:
            continue
        name, rest = found.groups()
        paths = PATH.findall(rest)
        if name == "connect":
            yield name, rest
        for path in paths[:2 if name.startswith(("rename", "link", "symlink")) else 1]:
            yield name, path.encode().decode("unicode_escape").encode("latin-1").decode("utf-8", "surrogateescape")


# Not newfstatat, which SQLite calls 10,000 times a second for what is open.
CALLS = ("trace=open,openat,openat2,creat,execve,execveat,connect,access,faccessat,faccessat2,statx,readlink,readlinkat,"
         "unlink,unlinkat,rename,renameat,renameat2,link,linkat,symlink,symlinkat,mkdir,mkdirat,mknod,mknodat,chdir,truncate")
ATTACHED = ["strace", "-f", "-s", "4096", "-e", CALLS]
STRACE = [*ATTACHED, "--seccomp-bpf", "-qq"]  # only these calls stop a process


def watched(command, trace, **more):
    """Runs `command` to its end: what subprocess.run gives, and its calls."""
    done = subprocess.run([*STRACE, "-o", str(trace), *map(str, command)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, errors="replace", stdin=subprocess.DEVNULL, **more)
    return done, list(calls(pathlib.Path(trace).read_text(errors="surrogateescape")))


class Attached:
    """Watches a process that runs already, from construction to end()."""

    def __init__(self, process, trace):
        self.trace = pathlib.Path(trace)
        self.strace = subprocess.Popen([*ATTACHED, "-o", str(trace), "-p", str(process)],
                                       stderr=subprocess.PIPE, text=True)
        said = self.strace.stderr.readline()
        if "attached" not in said:
            self.strace.wait()
            raise AssertionError(said)

    def end(self):
        self.strace.terminate()
        self.strace.stderr.close()
        self.strace.wait()
        return list(calls(self.trace.read_text(errors="surrogateescape")))


def is_system(path):
    """Also the folders themselves, what a process knows of its kin, and GDAL's settings, of a user's home."""
    return (path in ("", "/", "/proc", "/sys", "/usr/share/gdal", "/usr/share/proj") or path.endswith("/.gdal/gdalrc") or
            re.fullmatch(r"/proc/\d+/stat", path) is not None or os.path.normpath(path).startswith(SYSTEM))


def opened(seen):
    """What was opened that is not the system's."""
    return sorted({path for name, path in seen if name in OPENING and not is_system(path)})

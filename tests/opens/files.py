"""Small input files with what strangers may put into them."""
import gzip
import io
import pickle
import random
import struct

import numpy


def records(pairs):
    return b"".join(struct.pack("<H16sHH32s", 0, user, number, len(payload), b"") + payload for user, number, payload in pairs)


def las(wkt=None, citation=None, name=b"", system=b"", generator=b""):
    """A LAS file of a hundred points in the plane z = x y: with a record of WKT, or with GeoTIFF keys that have a citation."""
    kept = []
    if wkt is not None:
        kept.append((b"LASF_Projection", 2112, wkt.encode()[:65535]))
    if citation is not None:
        ascii_ = citation.encode() + b"|"
        keys = [1, 1, 0, 4, 1024, 0, 1, 32767, 3072, 0, 1, 32767, 1026, 34737, len(ascii_), 0, 3073, 34737, len(ascii_), 0]
        kept += [(b"LASF_Projection", 34735, struct.pack("<20H", *keys)), (b"LASF_Projection", 34737, ascii_)]
    if name:
        kept.append((b"LASF_Spec", 4, (struct.pack("<HBB", 0, 6, 0) + name.ljust(32, b"\0")).ljust(192, b"\0")))
    extra, body = records(kept), b""
    rng = random.Random(1)
    for _ in range(100):
        x, y = rng.randrange(10**6), rng.randrange(10**6)
        body += struct.pack("<iiiHBBBBH", x, y, x * y // 10**6, 0, 9, 2, 0, 0, 0) + (struct.pack("<i", 7) if name else b"")
    head = struct.pack("<4sHHIHH8sBB32s32sHHHIIBHI5I", b"LASF", 0, 0, 0, 0, 0, b"", 1, 2, system, generator, 1, 2020, 227,
                       227 + len(extra), len(kept), 0, 24 if name else 20, 100, *[0] * 5)
    return head + struct.pack("<12d", *[0.001] * 3, *[0.0] * 3, *[1000.0, 0.0] * 3) + extra + body


POINTS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
XYZ = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS)


def gz(file):
    """Text whose header says that it was called `file`."""
    packed = io.BytesIO()
    with gzip.GzipFile(filename=file, mode="wb", fileobj=packed) as out:
        out.write(XYZ.encode())
    return packed.getvalue()


def zstd_with_dictionary(number):
    """A frame of one raw block that wants a dictionary of this number."""
    text = XYZ.encode()
    return (b"\x28\xb5\x2f\xfd" + bytes([0x23, len(text)]) + struct.pack("<I", number) +
            (len(text) << 3 | 1).to_bytes(3, "little") + text)


class Opener:
    """An object whose pickle opens a file when it is read."""
    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return open, (self.file,)


def npy_of_objects(file):
    header = "{'descr': '|O', 'fortran_order': False, 'shape': (1, 3), }".ljust(117) + "\n"
    return b"\x93NUMPY\1\0" + struct.pack("<H", len(header)) + header.encode() + pickle.dumps([Opener(file)] * 3)


def npy():
    out = io.BytesIO()
    numpy.save(out, numpy.array(POINTS, dtype=float))
    return out.getvalue()


def ply(file):
    return (f"ply\nformat ascii 1.0\ncomment TextureFile {file}\nobj_info {file}\nelement vertex 5\nproperty float x\n"
            "property float y\nproperty float z\nend_header\n" + XYZ).encode()


def obj(file):
    return (f"mtllib {file}\ncall {file}\ncsh cat {file}\nshadow_obj {file}\n" +
            "".join(f"v {x} {y} {z}\n" for x, y, z in POINTS) + f"usemtl {file}\nf 1 2 3\n").encode()


def off(file):
    return (f"OFF\n# {file}\n5 0 0\n" + XYZ).encode()


def stl(file):
    corners = "".join(f"vertex {x} {y} {z}\n" for x, y, z in POINTS[:3])
    return f"solid {file}\nfacet normal 0 0 1\nouter loop\n{corners}endloop\nendfacet\nendsolid {file}\n".encode()

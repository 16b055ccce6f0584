#!/usr/bin/python3
"""Rewrites LAS 1.4 files of point formats 6 to 10 with the smallest records: LAS 1.4, point format 0, 20 bytes a point.

Kept: the integers X, Y, Z, scale and offset, intensity, return number and count (to 7), classification (to 30; higher
ones become 31), user data, point source, and the WKT of the coordinate system. Dropped: GPS time, colours, scan angle.

    thin_las.py OUT_FOLDER IN.las ...
"""
import pathlib
import struct
import sys

import numpy as np


def thin(data: bytes) -> bytes:
    header_bytes, points_at, records = struct.unpack_from("<HII", data, 94)
    point_format, record_bytes = struct.unpack_from("<BH", data, 104)
    count = struct.unpack_from("<Q", data, 247)[0]
    if data[:4] != b"LASF" or data[24:26] != b"\x01\x04" or not 6 <= point_format <= 10:
        raise SystemExit("not LAS 1.4 with point format 6 to 10")
    points = np.frombuffer(data, np.uint8, count * record_bytes, points_at).reshape(count, record_bytes)

    wkt = b""
    at = header_bytes
    for _ in range(records):
        user, record_id, length = struct.unpack_from("<16sHH", data, at + 2)
        if user.rstrip(b"\0") == b"LASF_Projection" and record_id == 2112:
            wkt = data[at : at + 54 + length]
        at += 54 + length

    small = np.zeros((count, 20), np.uint8)
    small[:, 0:14] = points[:, 0:14]  # X, Y, Z, intensity
    returns = np.minimum(points[:, 14] & 15, 7) | (np.minimum(points[:, 14] >> 4, 7) << 3)
    small[:, 14] = returns
    small[:, 15] = np.minimum(points[:, 16], 31)
    small[:, 17] = points[:, 17]
    small[:, 18:20] = points[:, 20:22]

    header = bytearray(data[:375])
    struct.pack_into("<H", header, 6, 16)  # the coordinate system is WKT
    struct.pack_into("<HII", header, 94, 375, 375 + len(wkt), 1 if wkt else 0)
    struct.pack_into("<BHI", header, 104, 0, 20, count)
    by_return = [int(np.sum((returns & 7) == r)) for r in range(1, 6)]
    struct.pack_into("<5I", header, 111, *by_return)
    struct.pack_into("<QQI", header, 227, 0, 0, 0)  # no wave packets, no extended records
    struct.pack_into("<Q15Q", header, 247, count, *by_return, *[0] * 10)
    return bytes(header) + wkt + small.tobytes()


folder = pathlib.Path(sys.argv[1])
for name in sys.argv[2:]:
    (folder / pathlib.Path(name).name).write_bytes(thin(pathlib.Path(name).read_bytes()))

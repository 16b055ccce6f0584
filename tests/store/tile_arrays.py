"""The arrays of a tile file, read by its specification alone (src/result/store/FORMAT.md)."""
import re
import struct
import zlib
from xml.sax.saxutils import unescape

import numpy as np

DTYPES = {"UInt8": "u1", "Int8": "i1", "UInt16": "<u2", "Int16": "<i2", "UInt32": "<u4", "Int32": "<i4", "UInt64": "<u8",
          "Int64": "<i8", "Float32": "<f4", "Float64": "<f8"}


def unpacked(data, at):
    blocks, block, last = struct.unpack_from("<3Q", data, at)
    sizes = struct.unpack_from(f"<{blocks}Q", data, at + 24)
    at += 24 + 8 * blocks
    parts = []
    for size in sizes:
        parts.append(zlib.decompress(data[at:at + size]))
        at += size
    assert all(len(part) == block for part in parts[:-1])
    assert not parts or len(parts[-1]) == (last or block)
    return b"".join(parts)


def read_tile(path):
    """{"Points": array, "PointData/id": array, ...} in the order of the file."""
    with open(path, "rb") as file:
        data = file.read()
    begin = data.index(b'<AppendedData encoding="raw">\n_')
    header, begin = data[:begin].decode(), data.index(b"_", begin) + 1
    arrays = {}
    for section, lines in re.findall(r"<(Points|PointData|Cells|CellData)>\n(.*?)</\1>", header, re.DOTALL):
        for kind, name, columns, offset in re.findall(
                r'type="(\w+)" Name="([^"]*)" NumberOfComponents="(\d+)" format="appended" offset="(\d+)"', lines):
            values = np.frombuffer(unpacked(data, begin + int(offset)), DTYPES[kind])
            if int(columns) > 1:
                values = values.reshape(-1, int(columns))
            name = unescape(name, {"&quot;": '"'})
            arrays[name if section == "Points" else f"{section}/{name}"] = values
    return arrays

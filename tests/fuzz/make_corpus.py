#!/usr/bin/env python3
"""make_corpus.py DATA OUT: cuts the real point files in DATA down to a few points each, as seeds for the fuzz targets.

LAS files keep their header and variable length records (payloads over 600 bytes are cut) and the first 3 points; texts
their first 5 lines; PLY their header, with the counts made small, and 3 vertices. NumPy arrays and a PLY with lists,
which DATA lacks, are made here. Only files whose licence lets us pass them on are taken.
"""
import pathlib
import re
import struct
import sys

LAS = ['ign_77050_627755.las', 'autzen_trim.las', 'pdal_epsg_4326.las', 'pdal_hexbin_crop.las', 'liblas_certainty3d.las',
       'lone_star.las', 'lion_takanawa.copc.las', 'laspy_grid.las', 'laz_conformance/pdrf6-1.4.las',
       'laz_conformance/pdrf7-v4-1.4.las']
TEXT = ['velodyne_400.csv', 'cities.csv']
POINTS = 3


def small_las(data):
    header_bytes, points_at, vlrs, _, record_bytes, _ = struct.unpack_from('<HIIBHI', data, 94)
    header = bytearray(data[:header_bytes])
    at, kept = header_bytes, b''
    for _ in range(vlrs):
        length, = struct.unpack_from('<H', data, at + 20)
        head, payload = bytearray(data[at:at + 54]), data[at + 54:at + 54 + length][:600]
        struct.pack_into('<H', head, 20, len(payload))
        kept += bytes(head) + payload
        at += 54 + length
    struct.pack_into('<I', header, 96, header_bytes + len(kept))
    if struct.unpack_from('<I', header, 107)[0]:
        struct.pack_into('<I', header, 107, POINTS)
    if data[25] == 4:
        struct.pack_into('<QIQ', header, 235, 0, 0, POINTS)
    return bytes(header) + kept + data[points_at:points_at + POINTS * record_bytes]


def small_ply(data, vertex_bytes):
    end = data.index(b'end_header\n') + len(b'end_header\n')
    header = re.sub(rb'element vertex \d+', b'element vertex %d' % POINTS, data[:end])
    header = re.sub(rb'element face \d+', b'element face 0', header)
    if b'format ascii' in header:
        return header + b'\n'.join(data[end:].split(b'\n', POINTS)[:POINTS]) + b'\n'
    return header + data[end:end + POINTS * vertex_bytes]


def list_ply(order):
    header = (f'ply\nformat binary_{"little" if order == "<" else "big"}_endian 1.0\nelement face 1\n'
              'property list uchar int vertex_indices\nelement vertex 2\nproperty list ushort float w\n'
              'property double x\nproperty short y\nproperty float z\nproperty uchar red\nend_header\n')
    return header.encode() + struct.pack(order + 'B3i', 3, 0, 1, 2) + struct.pack(
        order + 'HffdhfB', 2, 1, 2, 0.5, -3, 7, 9) + struct.pack(order + 'HdhfB', 0, 1.5, 4, 8, 10)


def npy(kind, columns):
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': (2, {columns}), }}".ljust(117) + '\n'
    return b'\x93NUMPY\1\0' + struct.pack('<H', len(text)) + text.encode() + struct.pack(
        kind[0] + str(2 * columns) + {'4': 'f', '8': 'd'}[kind[2]], *range(2 * columns))


def main():
    data, out = map(pathlib.Path, sys.argv[1:3])

    def write(folder, name, content):
        (out / folder).mkdir(parents=True, exist_ok=True)
        (out / folder / name).write_bytes(content)

    for name in LAS:
        write('las', pathlib.Path(name).name, small_las((data / name).read_bytes()))
    for name in TEXT:
        write('text', name, b'\n'.join((data / name).read_bytes().split(b'\n')[:5]) + b'\n')
    write('text', 'semicolons.txt', b'# comment\n"x" ; "y" ; "z" ; "a, b"\n1;2;3;nan\n-1e300;+2.5;inf;\n')
    write('text', 'normals.xyz', b'-0.72189 -0.1597 -0.1084 0.34047 0.93771 -0.069\n0.14523 -0.16346 0.1071 0.82 0.3 0.48\n')
    write('text', 'tabs.tsv', b'\xef\xbb\xbfE\tN\theight\tname\r\n1\t2\t3\tfour\r\n\r\n5\t6\t7\t\r\n')
    write('ply', 'csf_sample.ply', small_ply((data / 'csf_sample.ply').read_bytes(), 24))
    write('ply', 'isprs_CSite2.ply', small_ply((data / 'isprs_CSite2.ply').read_bytes(), 12))
    write('ply', 'ascii.ply', b'ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex 2\n'
          b'property float x\nproperty float y\nproperty list char int w\nproperty float z\nend_header\n3 0 1 2\n1 2 1 9 3\n4 5 0 6\n')
    write('ply', 'list_little.ply', list_ply('<'))
    write('ply', 'list_big.ply', list_ply('>'))
    for kind in ('<f8', '>f8', '<f4', '>f4'):
        for columns in (2, 3):
            write('npy', f'{"le" if kind[0] == "<" else "be"}_{kind[1:]}_{columns}.npy', npy(kind, columns))


main()

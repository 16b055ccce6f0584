#!/usr/bin/env python3
"""make_corpus.py DATA OUT: cuts the real point files in DATA down to a few points each, as seeds for the fuzz targets.

LAS files keep their header and variable length records (payloads over 600 bytes are cut) and the first 3 points; texts
their first 5 lines; PLY their header, with the counts made small, and 3 vertices. NumPy arrays, a PLY with lists, OFF, OBJ,
STL, PCD, PTX and PTS, which DATA lacks, are made here. Only files whose licence lets us pass them on are taken.
"""
import gzip
import json
import pathlib
import re
import struct
import subprocess
import sys

LAS = ['ign_77050_627755.las', 'autzen_trim.las', 'pdal_epsg_4326.las', 'pdal_hexbin_crop.las', 'liblas_certainty3d.las',
       'lone_star.las', 'lion_takanawa.copc.las', 'laspy_grid.las', 'laz_conformance/pdrf6-1.4.las',
       'laz_conformance/pdrf7-v4-1.4.las']
TEXT = ['velodyne_400.csv', 'cities.csv']
LAZ = ['lone_star.laz', 'autzen_trim.laz', 'laz_conformance/pdrf6-1.4.laz', 'laz_conformance/pdrf7-v4-1.4.laz']
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


def las_head(data, points, records, count_at_247):
    """The header and variable length records, with these replaced, for `points` points."""
    header_bytes, = struct.unpack_from('<H', data, 94)
    header = bytearray(data[:header_bytes])
    vlrs = b''.join(struct.pack('<H16sHH32s', 0, user, number, len(payload), b'') + payload for user, number, payload in records)
    struct.pack_into('<II', header, 96, header_bytes + len(vlrs), len(records))
    struct.pack_into('<I', header, 107, 0 if count_at_247 else points)
    if count_at_247:
        struct.pack_into('<QIQ', header, 235, 0, 0, points)
    return bytes(header) + vlrs


def laszip_record(data):
    at, = struct.unpack_from('<H', data, 94)
    for _ in range(struct.unpack_from('<I', data, 100)[0]):
        length, = struct.unpack_from('<H', data, at + 20)
        if struct.unpack_from('<H', data, at + 18)[0] == 22204:
            return bytearray(data[at + 54:at + 54 + length])
        at += 54 + length


def one_chunk_table(size):
    """The chunk table of one chunk: its size after 0, coded by models that have learnt nothing yet."""
    def flat(symbols, symbol):  # the cumulative shares of fresh models
        scale = 0x80000000 // symbols
        return (scale * symbol) >> 16, (scale * (symbol + 1)) >> 16 if symbol + 1 < symbols else None

    low, length, shift = 0, 0xFFFFFFFF, 0

    def narrow(begin, end, unit_bits):
        nonlocal low, length, shift
        unit = length >> unit_bits
        high = length if end is None else end * unit
        low, length = low + begin * unit, high - begin * unit
        while length < 1 << 24:
            low, length, shift = low << 8, length << 8, shift + 8

    bits = (size - 1).bit_length()  # of 2^(bits-1) + 1 .. 2^bits
    narrow(*flat(33, bits), 15)
    correction = size - 1
    upper = min(bits, 8)
    narrow(*flat(1 << upper, correction >> (bits - upper)), 15)
    if bits > upper:
        rest = correction & ((1 << (bits - upper)) - 1)
        length >>= bits - upper
        low += rest * length
        while length < 1 << 24:
            low, length, shift = low << 8, length << 8, shift + 8
    value = low + length // 2
    return struct.pack('<II', 0, 1) + value.to_bytes(4 + shift // 8, 'big') + bytes(2)


def small_laz(data, points):
    """Formats 0 to 3: the first points, as a file that is not chunked. 6 to 8: the first chunk."""
    record = laszip_record(data)
    points_at, = struct.unpack_from('<I', data, 96)
    if data[104] & 0x7F < 6:
        struct.pack_into('<H', record, 0, 1)
        head = las_head(data, points, [(b'laszip encoded', 22204, bytes(record))], data[25] == 4)
        return head + data[points_at + 8:points_at + 8 + 34 + 16 * points]
    size = 34 if data[104] & 0x7F == 6 else 40
    layers = {34: 13, 40: 14}[size]
    count, *lengths = struct.unpack_from('<I%dI' % layers, data, points_at + 8 + size)
    chunk = data[points_at + 8:points_at + 8 + size + 4 + 4 * layers + sum(lengths)]
    head = las_head(data, count, [(b'laszip encoded', 22204, bytes(record))], True)
    return head + struct.pack('<q', len(head) + 8 + len(chunk)) + chunk + one_chunk_table(len(chunk))


def small_copc(data):
    """The first chunk again, as the root of an octree of one node; the hierarchy stands behind the chunk table."""
    plain = small_laz(data, 0)
    points_at, = struct.unpack_from('<I', plain, 96)
    count, = struct.unpack_from('<Q', plain, 247)
    body = plain[points_at + 8:]
    lo, hi = struct.unpack_from('<6d', plain, 179)[1::2], struct.unpack_from('<6d', plain, 179)[0::2]
    half = max(b - a for a, b in zip(lo, hi)) / 2 + 1
    record = bytes(laszip_record(plain))
    head = las_head(plain, count, [(b'copc', 1, bytes(160)), (b'laszip encoded', 22204, record)], True)
    table, = struct.unpack_from('<q', plain, points_at)
    chunk_bytes = table - points_at - 8
    hierarchy_at = len(head) + 8 + len(body)
    info = struct.pack('<5dQQ2d', *[a + half for a in lo], half, 1.0, hierarchy_at, 32, 0, 1).ljust(160, b'\0')
    head = las_head(plain, count, [(b'copc', 1, info), (b'laszip encoded', 22204, record)], True)
    return (head + struct.pack('<q', len(head) + 8 + chunk_bytes) + body +
            struct.pack('<4iQii', 0, 0, 0, 0, len(head) + 8, chunk_bytes, count))


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


def binary_stl():
    triangle = struct.pack('<12fH', 0, 0, float('nan'), 0, 0, 0, 1, 0, 0, 0, 1.5, 2, 0x7fff)
    return b'solid, but binary'.ljust(80) + struct.pack('<I', 2) + 2 * triangle


def integers(numbers, relative, pack):
    """A block of src/result/store/FORMAT.md: relative to the least of the numbers (0), or to the one before (1)."""
    base = numbers[0] if relative else min(numbers)
    moved = [a - b for a, b in zip(numbers, [base] + numbers[:-1] if relative else [base] * len(numbers))]
    if relative:
        moved = [2 * m if m >= 0 else -2 * m - 1 for m in moved]
    planes = [bytes(m >> 8 * p & 255 for m in moved) for p in range((max(moved).bit_length() + 7) // 8)]
    packed = [min((plane, pack(plane)), key=len) for plane in planes]
    return (struct.pack('<BBQ', relative if planes else 0, len(planes), base) +
            b''.join(struct.pack('<I', len(p)) for p in packed) + b''.join(packed))


def points_file(own, foreign, attributes, pack, areas=()):
    """A file of points in 2D without checksums: fuzz_points sets them. Points: (x, y, id, owner, attributes...)."""
    sign = 1 << 63
    cents = lambda values: b'\x0b' + integers([round(100 * v) + sign for v in values], 1, pack) + integers([0] * len(values), 0, pack)
    bits = lambda values: b'\0' + integers([struct.unpack('<Q', struct.pack('<d', v))[0] ^ sign for v in values], 0, pack)
    column = lambda points, i: [p[i] for p in points]
    blocks = []
    for points, columns in ((own, 3), (foreign, 4)):
        for i in range(columns if points else 0):
            blocks.append(cents(column(points, i)) if i < 2 else integers(column(points, i), i % 2, pack))
    for i, (_, kind) in enumerate(attributes):
        for points in filter(None, (own, foreign)):
            values = column(points, 4 + i)
            blocks.append(bits(values) if kind == 9 else integers(values, 0, pack))
    if areas:
        blocks.append(bits(areas))
    named = [(0, *attribute) for attribute in attributes] + ([(1, b'area', 9)] if areas else [])
    columns = b''.join(struct.pack('<BBQ', of_cells, kind, len(name)) + name for of_cells, name, kind in named)
    head = 17 + 28 + len(columns) + 12 * len(blocks) + 8
    return (b'Tessera points 2\n' + struct.pack('<7I', head, 2, 42, len(own), len(foreign), len(areas), len(named)) + columns +
            b''.join(struct.pack('<IQ', len(b), 0) for b in blocks) + bytes(8) + b''.join(blocks))


def ept(kind, tile, pages, points, tiles=1):
    """ept.json, the first page of the hierarchy, all other pages, and all tiles; zero bytes between them."""
    numbers = [('X', 'signed', 4, .01, 100), ('Y', 'signed', 4, .01, -50), ('Z', 'signed', 4, .01, 0), ('Intensity', 'unsigned', 2, 1, 0),
               ('GpsTime', 'float', 8, 1, 0), ('ScanAngleRank', 'signed', 2, .006, 0)]
    described = {'bounds': [100, -50, 0, 228, 78, 128], 'boundsConforming': [100, -50, 0, 228, 78, 128], 'dataType': kind, 'hierarchyType': 'json',
                 'points': points * tiles, 'span': 128, 'srs': {'authority': 'EPSG', 'horizontal': '2154'}, 'version': '1.1.0',
                 'schema': [{'name': n, 'type': t, 'size': s, 'scale': scale, 'offset': offset} for n, t, s, scale, offset in numbers]}
    return b'\0'.join([json.dumps(text).encode() for text in (described, *pages)] + [tile])


def fits_table(columns, rows):
    """A FITS file with one table: (name, form) of each column, perhaps with a further card and its value."""
    card = lambda key, value: f'{key:8}= {value:>20}'
    width = {'D': 8, 'E': 4, 'K': 8, 'I': 2, 'J': 4, 'L': 1, 'A': 1, 'P': 8}
    bytes_of = lambda form: 2 if form[-1] == 'X' else int(form[0]) * width[form[1]]
    row = sum(bytes_of(form) for _, form, *_ in columns)
    lines = [card('XTENSION', "'BINTABLE'"), card('BITPIX', 8), card('NAXIS', 2), card('NAXIS1', row), card('NAXIS2', len(rows) // row),
             card('PCOUNT', 0), card('GCOUNT', 1), card('TFIELDS', len(columns))]
    for i, (name, form, *more) in enumerate(columns, 1):
        lines += [card(f'TTYPE{i}', f"'{name}'"), card(f'TFORM{i}', f"'{form}'")] + ([card(f'{more[0]}{i}', more[1])] if more else [])
    header = lambda lines: b''.join(f'{line:80}'.encode() for line in [*lines, 'END']).ljust(2880)
    return header([card('SIMPLE', 'T'), card('BITPIX', 8), card('NAXIS', 0)]) + header(lines) + rows


def main():
    data, out = map(pathlib.Path, sys.argv[1:3])

    def write(folder, name, content):
        (out / folder).mkdir(parents=True, exist_ok=True)
        (out / folder / name).write_bytes(content)

    for name in LAS:
        write('las', pathlib.Path(name).name, small_las((data / name).read_bytes()))
    for name in LAZ:
        write('laz', pathlib.Path(name).name, small_laz((data / name).read_bytes(), 200))
    write('laz', 'small.copc.laz', small_copc((data / LAZ[2]).read_bytes()))
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
    write('off', 'cube_corner.off', b'# made\nOFF\n4 1 0\n0 0 0\n1 0 0 # x\n0 1.5e0 0\n\n0 0 2e-300\n3 0 1 2\n')
    write('off', 'all.off', b'STCNOFF 2 0 0\n1 2 3 0 0 1 255 128 0 64 .25 .75\n4 5 6 0 0 1 9 8 7 6 0 1\n')
    write('obj', 'scene.obj', b'# made\nmtllib a.mtl\no one\nv 0 0 0\nvt 1 1\nv 1 0 \\\n 0\nv 0 1.5e0 2 1\nf 1/1 2/1 \\\nv 3/1\n')
    write('obj', 'colours.obj', b'v 0 0 0 .25 .5 .75\nv 1 2 3\nv 4 5 6 1 0 0 1\n')
    pcd = b'# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb _\nSIZE 4 4 4 4 1\nTYPE F F F U U\nCOUNT 1 1 1 1 1\nWIDTH 2\nHEIGHT 1\nPOINTS 2\nDATA '
    write('pcd', 'text.pcd', pcd + b'ascii\n0 0 0.5 4278387457 1\n1 -2.5 3 1e-40 2\n')
    write('pcd', 'binary.pcd', pcd + b'binary\n' + 2 * struct.pack('<fffIB', 1, 2, 3, 4, 5))
    write('pcd', 'compressed.pcd', pcd + b'binary_compressed\n' + struct.pack('<II', 11, 34) +
          bytes([3, 0, 0, 128, 63, 0xe0, 3, 3, 0xe0, 9, 7]))
    scan = b'1\n2\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n5 6 7 1\n'
    write('ptx', 'scans.ptx', scan + b'1 2 3 0.5\n0 0 0 0.5\n' + scan + b'1 2 3 0.5\n4 5 6 .25\n')
    write('pts', 'parts.pts', b'2\n1 2 3 -7 1 2 3\n4 5 6 9 255 0 1\n1\n7 8 9 0 0 0 0\n')
    write('stl', 'text.stl', b'solid a\n' + 2 * b'facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1.5 0\n'
          b'endloop\nendfacet\n' + b'endsolid a\n')
    write('stl', 'binary.stl', binary_stl())
    for kind in ('<f8', '>f8', '<f4', '>f4'):
        for columns in (2, 3):
            write('npy', f'{"le" if kind[0] == "<" else "be"}_{kind[1:]}_{columns}.npy', npy(kind, columns))

    columns = [('RA', '1D'), ('DEC', '1D'), ('Z', '1E'), ('ID', '1K', 'TZERO', 2**63), ('MAG', '1I', 'TSCAL', 0.5), ('N', '1J', 'TNULL', -1),
               ('SHAPE', '2E'), ('FLAG', '1L'), ('NAME', '3A'), ('BITS', '9X')]
    rows = b''.join(struct.pack('>ddfqhiffc3s2x', 40 * i, 9 * i, i / 8, i - 2**63, i, i - 1, i, -i, b'FT'[i % 2:][:1], b'abc') for i in range(4))
    write('fits', 'sky.fits', fits_table(columns, rows))
    write('fits', 'positions.fits', fits_table([('pos', '3E'), ('list', '1PE')], b''.join(struct.pack('>fffii', i, i * i, 9 - i, 0, 0) for i in range(3))))

    text = b''.join(b'%d %d 0.5\n' % (i, i * i % 97) for i in range(60))
    las = small_las((data / LAS[0]).read_bytes())
    write('packed', 'two_members.xyz.gz', gzip.compress(text[:300], mtime=0) + gzip.compress(text[300:], mtime=0))
    write('packed', 'small.las.gz', gzip.compress(las, mtime=0))
    zstd = lambda data: subprocess.run(['zstd', '-q', '-c'], input=data, stdout=subprocess.PIPE, check=True).stdout
    write('packed', 'skipped_and_two_frames.xyz.zst', b'\x50\x2a\x4d\x18\x02\0\0\0ab' + zstd(text[:300]) + zstd(text[300:]))
    write('packed', 'small.las.zst', zstd(las))

    records = b''.join(struct.pack('<iiiHdh', i * 997 % 12800, i * 31 % 12800, i * i % 12800, i, i / 8, -i) for i in range(20))
    two = ({'0-0-0-0': 20, '1-0-0-0': -1}, {'1-0-0-0': 20, '2-1-1-1': 20, '1-1-0-1': 0})
    write('ept', 'binary', ept('binary', records, two, 20, 3))
    write('ept', 'zstandard', ept('zstandard', zstd(records), two, 20, 3))
    laz = small_laz((data / LAZ[0]).read_bytes(), 200)
    write('ept', 'laszip', ept('laszip', laz, ({'0-0-0-0': 200}, {}), 200))

    many = [(i / 4, i % 40 / 100, 1000 - i, 42, i * i / 7, i % 3) for i in range(200)]
    few = [(9.25, 0.5, 7, 3, float('nan'), 1), (9.0, -0.25, 8, 41, -0.0, 2)]
    attributes = [(b'z', 9), (b'kind', 0)]
    plain = lambda plane: plane
    packed = lambda plane: subprocess.run(['zstd', '-q', '-1', '--no-check', f'--stream-size={len(plane)}', '-c'], input=plane,
                                          stdout=subprocess.PIPE, check=True).stdout
    write('points', 'plain.pts', points_file(many[:9], few, attributes, plain))
    write('points', 'packed.pts', points_file(many, few, attributes, packed))
    write('points', 'measured.pts', points_file(many, few, attributes, packed, [1 / (i + 1) for i in range(300)]))
    write('points', 'no_foreign.pts', points_file(many, [], [], packed))
    write('points', 'block', b'\x06\0\xc7' + integers([i * i for i in range(200)], 1, packed))


main()

"""Lets libraries of Debian 12 run with glibc 2.34 and the libstdc++ of GCC 11, which RHEL 9 and Ubuntu 22.04 have.

The libraries need few symbols that are newer, and for none of them a newer meaning: OLDER. A library says of each symbol
which version of it it was linked with, and the loader refuses systems without this version. lower() takes the version away
from these symbols: the loader then takes the system's own version. What older systems have not at all is in older_glibc.c.
"""
from __future__ import annotations

import pathlib
import re
import struct

GLIBC, GLIBCXX = 34, 29
# In older systems, too, under an older version.
OLDER = {"hypot",  # since 2.35 a faster one of the same name
         "_ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE"}  # since GCC 12 without noexcept
SUPPLIED = {"arc4random_buf", "_ZSt21__glibcxx_assert_failPKciS0_S0_"}
UNVERSIONED = 1


def too_new(version: str) -> bool:
    found = re.fullmatch(r"(GLIBC_2|GLIBCXX_3\.4)\.(\d+)(?:\.\d+)?", version)
    return found is not None and int(found[2]) > (GLIBC if found[1] == "GLIBC_2" else GLIBCXX)


def lower(path: pathlib.Path) -> set[str]:
    """Takes away versions that are too new. Returns which of SUPPLIED the library then needs from elsewhere."""
    content = bytearray(path.read_bytes())
    sections = _sections(content)
    if ".gnu.version_r" not in sections:
        return set()
    strings = sections[".dynstr"][0]
    newer = set()
    # Structures Verneed (16 bytes) and Vernaux (16 bytes) of the ELF specification of symbol versions.
    at = sections[".gnu.version_r"][0]
    while True:
        _, _, _, first, following = struct.unpack_from("<HHIII", content, at)
        entries, entry = [], at + first
        while True:
            hashed, flags, index, name, after = struct.unpack_from("<IHHII", content, entry)
            entries.append((entry, hashed, index, name, too_new(_text(content, strings + name))))
            if after == 0:
                break
            entry += after
        old = next(((hashed, name) for _, hashed, _, name, new in entries if not new), None)
        for place, _, index, name, new in entries:
            if new:
                if old is None:
                    raise ValueError(f"{path.name} needs nothing older than {_text(content, strings + name)} of a library")
                newer.add(index)
                # No symbol has this entry any more. It becomes a second entry of an old version.
                struct.pack_into("<I", content, place, old[0])
                struct.pack_into("<I", content, place + 8, old[1])
        if following == 0:
            break
        at += following
    changed = _take_versions_away(content, sections, newer)
    unknown = changed - OLDER - SUPPLIED
    if unknown:
        raise ValueError(f"{path.name} needs {', '.join(sorted(unknown))}, which glibc 2.{GLIBC} and GCC 11 do not have")
    if changed:
        path.write_bytes(content)
    return changed & SUPPLIED


def _take_versions_away(content: bytearray, sections: dict[str, tuple[int, int]], indices: set[int]) -> set[str]:
    """Takes the versions of these indices from the symbols that have them. Returns the names of the symbols."""
    symbols, size = sections[".dynsym"]
    names = set()
    for i in range(size // 24):
        place = sections[".gnu.version"][0] + 2 * i
        (index,) = struct.unpack_from("<H", content, place)
        if index & 0x7FFF in indices:
            (name,) = struct.unpack_from("<I", content, symbols + 24 * i)
            names.add(_text(content, sections[".dynstr"][0] + name))
            struct.pack_into("<H", content, place, UNVERSIONED)
    return names


def _sections(content: bytearray) -> dict[str, tuple[int, int]]:
    """Returns offset and size of each section of a 64-bit little-endian ELF file."""
    if content[:6] != b"\x7fELF\x02\x01":
        raise ValueError("only libraries of 64-bit little-endian machines are known")
    table, = struct.unpack_from("<Q", content, 0x28)
    size, count, of_names = struct.unpack_from("<HHH", content, 0x3A)
    headers = [struct.unpack_from("<IIQQQQ", content, table + size * i) for i in range(count)]
    names = headers[of_names][4]
    return {_text(content, names + name): (offset, length) for name, _, _, _, offset, length in headers}


def _text(content: bytearray, at: int) -> str:
    return content[at : content.index(0, at)].decode()

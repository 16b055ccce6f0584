"""What writes to the disk draws from the ledger of its job (src/base/ledger.h), by itself or through src/files."""
import pathlib
import re
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
# The system's calls, the standard library's files, and what GDAL writes.
WRITES = re.compile(r"(?<![\w:])::p?write\(|\bo?f?stream\s+\w+\(|\bofstream\b|\bfopen\(|\bcopy_file\(|\bGDALCreate(?:Copy)?\(|"
                    r"\bGDALDEMProcessing\(")
# What writes to memory alone: an array that its asker holds, files of the size of one map tile.
EXEMPT = {"src/result/terrain/hillshade.cc", "src/result/terrain/map_tile.cc"}


def writers():
    for path in sorted(p for folder in ("src", "actors") for p in (ROOT / folder).rglob("*") if p.suffix in (".h", ".cc")):
        name = str(path.relative_to(ROOT))
        code = "\n".join(line.split("//")[0] for line in path.read_text().splitlines())
        if name not in EXEMPT and WRITES.search(code):
            yield name, code


class Writes(unittest.TestCase):
    def test_what_writes_draws(self):
        self.assertEqual([name for name, code in writers() if "Ledger::draw_write(" not in code], [])

    def test_the_search_finds_what_it_is_for(self):
        found = {name for name, _ in writers()}
        for name in ("src/base/files/descriptor.cc", "src/result/store/direct_writer.cc", "src/input/bytes/spool.cc",
                     "src/result/export/geopackage.cc", "src/result/terrain/cog_file.cc"):
            self.assertIn(name, found)


if __name__ == "__main__":
    unittest.main()

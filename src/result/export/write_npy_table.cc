// One structured NumPy array of the points, in the order of the input.
#include <string>

#include "src/result/export/formats.h"
#include "src/result/export/output.h"
#include "src/result/export/point_table.h"

namespace tessera::exports {

namespace fs = std::filesystem;

namespace {

const char* array_type(AttributeType type) {
  constexpr const char* names[] = {"|u1", "|i1", "<u2", "<i2", "<u4", "<i4", "<u8", "<i8", "<f4", "<f8"};
  return names[static_cast<int>(type)];
}

// A text as a literal of Python.
std::string python_text(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "'";
}

// The head of a file: magic, version, length and a dictionary, padded so that the array begins at a multiple of 64.
// Version 3 is UTF-8, which names may need; it has four bytes for the length.
std::string array_head(const PointTable& table) {
  std::string text = "{'descr': [";
  for (const auto& column : table.columns())
    text += "(" + python_text(column.name) + ", '" + array_type(column.type) + "'), ";
  text += "], 'fortran_order': False, 'shape': (" + std::to_string(table.rows()) + ",), }";
  constexpr std::size_t before = 12, multiple = 64;
  text.resize((before + text.size() + 1 + multiple - 1) / multiple * multiple - before - 1, ' ');
  text += '\n';
  std::string head("\x93NUMPY\x03\x00", 8);
  for (int byte = 0; byte < 4; ++byte) head += static_cast<char>(text.size() >> (8 * byte) & 0xff);
  return head + text;
}

}  // namespace

Result<Exported> write_npy_table(const MeshSource& source, const fs::path& path) {
  BOOST_OUTCOME_TRY(table, PointTable::open(source, source.options.names));
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  Stream stream(file, 0);
  stream.text(array_head(table));
  BOOST_OUTCOME_TRYV(table.for_each(folder_of(path), [&](std::span<const std::byte> rows) {
    stream.bytes(rows);
    return stream.status();
  }));
  BOOST_OUTCOME_TRYV(stream.flush());
  BOOST_OUTCOME_TRY(bytes, file.finish());
  Exported exported;
  exported.vertices = table.rows();
  exported.files = 1;
  exported.bytes = bytes;
  return exported;
}

}  // namespace tessera::exports

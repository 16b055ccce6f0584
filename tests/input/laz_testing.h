// Decompressed records as they come, and the hashes by which manifests say what they should be.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "src/input/bytes/fields.h"
#include "src/input/las/las_header.h"
#include "src/input/laz/laz_file.h"
#include "tests/input/io_testing.h"

namespace tessera::testing_io {

// All bytes of a file.
inline Bytes file_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  return bytes_of(text);
}

struct Records {
  LasHeader header;
  Bytes bytes;
  std::size_t size() const { return bytes.size() / header.record_bytes; }
  std::int32_t integer(std::size_t record, std::size_t axis) const {
    return load<std::int32_t>(bytes.data() + record * header.record_bytes + 4 * axis);
  }
};

constexpr std::size_t coordinates_only = 0, all_fields = SIZE_MAX;

// All records of a LAS or LAZ file, with x, y, z and all that stands in their first `wanted_bytes` bytes.
inline Result<Records> read_records(std::unique_ptr<ByteSource> source, std::size_t wanted_bytes,
                                    const ReadHints& hints = {}) {
  BOOST_OUTCOME_TRY(header, read_las_header(*source));
  std::unique_ptr<RecordSource> stream;
  if (header.compressed) {
    laz::WantedFields plan{.record_bytes = header.record_bytes, .wanted = std::vector<bool>(header.record_bytes)};
    std::fill_n(plan.wanted.begin(), std::min<std::size_t>(wanted_bytes, header.record_bytes), true);
    BOOST_OUTCOME_TRY(opened, laz::open_laz_records(std::move(source), header, std::move(plan), hints));
    stream = std::move(opened.records);
  } else {
    stream = std::make_unique<RecordStream>(std::move(source), header.points_at, header.record_bytes, header.points);
  }
  Records records{.header = std::move(header), .bytes = {}};
  while (true) {
    BOOST_OUTCOME_TRY(block, stream->next(SIZE_MAX));
    if (block.empty()) return records;
    records.bytes.insert(records.bytes.end(), block.begin(), block.end());
  }
}

inline Result<Records> read_records(const std::filesystem::path& path, std::size_t wanted_bytes,
                                    const ReadHints& hints = {}) {
  BOOST_OUTCOME_TRY(source, open_file(path));
  return read_records(std::move(source), wanted_bytes, hints);
}

// The file without compression: its header as it is but for that bit, its own records, no records behind the points.
inline Bytes las_bytes(const std::filesystem::path& path) {
  const auto records = read_records(path, all_fields);
  EXPECT_EQ(sentence(records), "");
  Bytes las(records.value().header.points_at);
  EXPECT_EQ(sentence(open_file(path).value()->read(0, las)), "");
  put(las, 104, static_cast<std::uint8_t>(load<std::uint8_t>(las.data() + 104) & 0x3F));
  if (load<std::uint8_t>(las.data() + 25) >= 4) {
    put(las, 235, std::uint64_t{0});
    put(las, 243, std::uint32_t{0});
  }
  las.insert(las.end(), records.value().bytes.begin(), records.value().bytes.end());
  return las;
}

// In hexadecimal digits.
inline std::string sha256(const Bytes& bytes) {
  const TempFolder folder;
  const auto file = folder.write("bytes", bytes);
  std::FILE* pipe = ::popen(("sha256sum < '" + file.string() + "'").c_str(), "r");
  std::array<char, 65> digits{};
  const bool read = pipe != nullptr && std::fgets(digits.data(), digits.size(), pipe) != nullptr;
  if (pipe != nullptr) ::pclose(pipe);
  return read ? digits.data() : "sha256sum cannot be run";
}

// The hash `xyz_sha256` of manifest.json: of X * scale + offset as little-endian doubles, point after point, each
// coordinate rounded twice.
inline std::string xyz_sha256(const Records& records) {
  Bytes doubles;
  doubles.reserve(records.size() * 24);
  for (std::size_t i = 0; i < records.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double scaled = records.integer(i, axis) * records.header.scale[axis];
      push(doubles, scaled + records.header.offset[axis]);
    }
  return sha256(doubles);
}

}  // namespace tessera::testing_io

// Decompressed records as they come, and the hash by which the shared data says what they should be.
#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "src/io/bytes/fields.h"
#include "src/io/las/las_header.h"
#include "src/io/laz/laz_file.h"
#include "tests/io/io_testing.h"

namespace tessera::testing_io {

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
    laz::RecordPlan plan{.record_bytes = header.record_bytes, .wanted = std::vector<bool>(header.record_bytes)};
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

// The hash `xyz_sha256` of manifest.json: SHA-256, in hexadecimal digits, of X * scale + offset as little-endian
// doubles, point after point, each coordinate rounded twice.
inline std::string xyz_sha256(const Records& records) {
  Bytes doubles;
  doubles.reserve(records.size() * 24);
  for (std::size_t i = 0; i < records.size(); ++i)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double scaled = records.integer(i, axis) * records.header.scale[axis];
      push(doubles, scaled + records.header.offset[axis]);
    }
  const TempFolder folder;
  const auto file = folder.write("xyz", doubles);
  std::FILE* pipe = ::popen(("sha256sum < '" + file.string() + "'").c_str(), "r");
  std::array<char, 65> digits{};
  const bool read = pipe != nullptr && std::fgets(digits.data(), digits.size(), pipe) != nullptr;
  if (pipe != nullptr) ::pclose(pipe);
  return read ? digits.data() : "sha256sum cannot be run";
}

}  // namespace tessera::testing_io

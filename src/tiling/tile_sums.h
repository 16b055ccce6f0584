// Checksums of the files of a run folder, and what is said when one is damaged.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "src/base/result.h"

namespace tessera {

// record_checksum() of a tile's points, and of its rows of attributes (0 when nothing is carried). They do not depend
// on how the files were appended to: neither on buffers nor on batches.
struct TileSums {
  std::uint64_t points = 0, rows = 0;
  friend bool operator==(const TileSums&, const TileSums&) = default;
};

// Whether a tile's files have been found whole by this process.
struct TileChecked {
  std::atomic<bool> points = false, rows = false;
};

// Error corrupt: what is wrong with a file of a run folder, and that the run has to start again.
Error damaged_run(const std::filesystem::path& path, const std::string& what);
Error wrong_size(const std::filesystem::path& path, std::uint64_t bytes, std::uint64_t records,
                 std::size_t record_bytes);
Error wrong_sum(const std::filesystem::path& path, std::uint64_t sum, std::uint64_t written);

// Reads the file through a small buffer. Error corrupt unless it has so many records with this sum; io.
Status check_records(const std::filesystem::path& path, std::uint64_t records, std::size_t record_bytes,
                     std::uint64_t sum);

}  // namespace tessera

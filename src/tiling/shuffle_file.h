// Routed points on disk. What one buffer held is a bundle: one file, whatever the number of tiles.
//
//   RUN/points/000000-000007.bin      LocalPoint records (32 bytes), of one tile after the other
//   RUN/attributes/000000-000007.bin  rows in the same order; absent when nothing is carried
//
// A tile's records in a bundle are a segment, by ascending id; those of its segments, in their order, ascend as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

struct ShuffleFile {
  ShuffleFileId id;
  std::uint64_t first_id = 0;  // is added to the ids in the file
  std::uint64_t points = 0;
  friend bool operator==(const ShuffleFile&, const ShuffleFile&) = default;
};

// Goes to disk as it is.
struct Segment {
  std::uint32_t bundle = 0;  // of a list of them
  std::uint32_t count = 0;
  std::uint64_t begin = 0;                     // its first record
  std::uint64_t first_id = 0;                  // of that record, as it is in the file
  std::uint64_t points_sum = 0, rows_sum = 0;  // record_checksum(); 0 when nothing is carried
  friend bool operator==(const Segment&, const Segment&) = default;
};
static_assert(sizeof(Segment) == 40);

// Where records are read from.
struct ShuffleFiles {
  std::filesystem::path run_folder;
  std::span<const ShuffleFile> bundles;
  std::size_t row_bytes = 0;
};

// Calls `visit` with the records of segments in order, in chunks, with ids as they are in the cloud; without their rows
// if row_bytes is 0. Error corrupt, which names the file, when a segment is not what was written: then `visit` may have
// had some of it. `stop`: error interrupted.
using VisitRecords = std::function<Status(std::span<const LocalPoint>, std::span<const std::byte>)>;
Status for_each_record(const ShuffleFiles& files, std::span<const Segment> segments, const std::stop_token& stop,
                       const VisitRecords& visit);

// The records of a segment in one piece, checked; ids as they are in the cloud. REQUIRES: to.size() is its count.
Status read_points(const ShuffleFiles& files, const Segment& segment, std::span<LocalPoint> to);

// Whether a segment's rows are those that were written, too.
Status check_rows(const ShuffleFiles& files, const Segment& segment);

// Gives the disk of records back that are not read any more. Where the file system cannot, they stay.
Status give_back(const ShuffleFiles& files, std::span<const Segment> segments);

// Error corrupt: what is wrong with a file of a run folder, and that the run has to start again.
Error damaged_run(const std::filesystem::path& path, const std::string& what);

}  // namespace tessera

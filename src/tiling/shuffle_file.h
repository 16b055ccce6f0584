// Routed points on disk. A shuffle file (a "bundle" in names) has the points that one buffer held, however many tiles
// there are.
//
//   RUN/points/000000-000007.bin      LocalPoint records (32 bytes), one tile after the other
//   RUN/attributes/000000-000007.bin  rows in the same order; absent when points have no attributes
//
// A tile's records in a shuffle file are a segment, by ascending id. Ids also ascend from one segment of a tile to the
// next.
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
  std::uint64_t first_id = 0;  // to be added to the ids in the file
  std::uint64_t points = 0;
  friend bool operator==(const ShuffleFile&, const ShuffleFile&) = default;
};

// The records of one tile in a shuffle file. Goes to disk as it is in memory.
struct Segment {
  std::uint32_t bundle = 0;  // index in the list of shuffle files
  std::uint32_t count = 0;
  std::uint64_t begin = 0;                     // index of its first record
  std::uint64_t first_id = 0;                  // id of the first record, as it is in the file
  std::uint64_t points_sum = 0, rows_sum = 0;  // record_checksum(); rows_sum is 0 when points have no attributes
  friend bool operator==(const Segment&, const Segment&) = default;
};
static_assert(sizeof(Segment) == 40);

// Where records are read from.
struct ShuffleFiles {
  std::filesystem::path run_folder;
  std::span<const ShuffleFile> bundles;
  std::size_t row_bytes = 0;
};

// Calls `visit` with the records of segments, in order and in chunks, with ids as they are in the cloud. The rows are
// empty if row_bytes is 0. Error corrupt names the file when a segment is not what was written; then `visit` may have
// had some of it. Error interrupted soon after `stop` is requested.
using VisitRecords = std::function<Status(std::span<const LocalPoint>, std::span<const std::byte>)>;
Status for_each_record(const ShuffleFiles& files, std::span<const Segment> segments, const std::stop_token& stop,
                       const VisitRecords& visit);

// Reads the records of a segment in one piece and checks them; ids are as they are in the cloud. REQUIRES: to.size() is
// segment.count.
Status read_points(const ShuffleFiles& files, const Segment& segment, std::span<LocalPoint> to);

// Checks that a segment's rows are those that were written. Error corrupt.
Status check_rows(const ShuffleFiles& files, const Segment& segment);

// Gives back the disk space of records that are not read any more. Where the file system cannot do that, the records
// stay.
Status give_back(const ShuffleFiles& files, std::span<const Segment> segments);

// Returns error corrupt, with a sentence: what is wrong with a file of a run folder, and that the run has to start
// again.
Error damaged_run(const std::filesystem::path& path, const std::string& what);

}  // namespace tessera

#include "src/input/cloud/input_splits.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "src/input/bytes/record_stream.h"

namespace tessera {
namespace {

using Of = InputSplit::Range::Of;

}  // namespace

Result<std::vector<InputSplit>> cut_into_splits(const Cloud& cloud, std::uint64_t points) {
  points = std::max<std::uint64_t>(points, batch_points_max);
  std::vector<InputSplit> splits;
  std::uint64_t filled = 0;  // the points of the last split
  // Adds a range to the last split if it fits, else to a new split.
  const auto add = [&](InputSplit::Range range, std::uint64_t count, bool here) {
    if (splits.empty() || splits.back().here != here || (filled > 0 && filled + count > points)) {
      splits.push_back({{}, here});
      filled = 0;
    }
    splits.back().ranges.push_back(range);
    filled += count;
  };
  for (std::size_t i = 0; i < cloud.files().size(); ++i) {
    const FileInfo& file = cloud.files()[i];
    const std::uint64_t count = file.about_points();
    if (cloud.is_spooled(i)) {
      add({i}, 0, true);
    } else if (count <= points) {
      add({i}, count, false);
    } else if (file.points) {
      // A file is not entered where entering would read as much as a split, nor where the number of points in between
      // is unknown.
      bool enter = file.seek_points <= points / 4 && file.points_passed_over == 0;
      if (enter) {
        BOOST_OUTCOME_TRY(reader, cloud.reopen(i, {}, {}));
        BOOST_OUTCOME_TRY(can_seek, reader->seek(0));
        enter = can_seek;
      }
      const std::uint64_t pieces = enter ? (count + points - 1) / points : 1;
      if (pieces == 1) add({i}, count, false);
      for (std::uint64_t k = 0, begin = 0; pieces > 1 && k < pieces; ++k) {
        const std::uint64_t piece = count / pieces + (k < count % pieces);
        add({i, Of::points, begin, piece}, points, false);
        begin += piece;
      }
    } else {
      const std::uint64_t pieces = std::min(file.parts, (count + points - 1) / points);
      for (std::uint64_t k = 0, begin = 0; k < pieces; ++k) {
        const std::uint64_t piece = file.parts / pieces + (k < file.parts % pieces);
        add({i, Of::parts, begin, piece}, points, false);
        begin += piece;
      }
    }
  }
  return splits;
}

}  // namespace tessera

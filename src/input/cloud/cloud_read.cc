// Cloud::for_each_batch(). Batches come in the order of the input, because ids, tile files and the choice of seeds
// depend on this order. Threads only read ahead.
#include <cstdint>
#include <functional>
#include <new>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "src/input/bytes/record_stream.h"
#include "src/input/cloud/batch_queue.h"
#include "src/input/cloud/cloud.h"
#include "src/input/cloud/in_order.h"
#include "src/input/cloud/point_filter.h"

namespace tessera {
namespace {

using Sink = std::function<Status(CloudBatch&)>;

// A row may be much larger than its line of text, when the header names many columns. Text with larger rows is not read
// ahead in parts.
constexpr std::size_t text_row_bytes_max = 128;
constexpr std::uint64_t rows_bytes_max = std::uint64_t{8} << 20;

// A file, or a part of a file, that one thread reads.
struct Unit {
  std::size_t file;
  std::optional<std::uint64_t> part;            // none: the unit is not one of the file's parts
  bool ahead;                                   // small enough to be read before it is needed
  std::uint64_t begin = 0, count = UINT64_MAX;  // points
};

std::vector<Unit> units_of(const InputSplit& split, const std::vector<FileInfo>& files,
                           const std::vector<Attribute>& schema) {
  std::vector<Unit> units;
  for (const InputSplit::Range& range : split.ranges) {
    const FileInfo& file = files[range.file];
    const bool in_parts = row_bytes(schema) <= text_row_bytes_max;
    if (file.points) {
      Unit unit{range.file, {}, false};
      if (range.of == InputSplit::Range::Of::points) unit = {range.file, {}, false, range.begin, range.count};
      const std::uint64_t points = std::min(unit.count, *file.points);
      unit.ahead = points <= batch_points_max && points * row_bytes(schema) <= rows_bytes_max;
      units.push_back(unit);
    } else if (range.of == InputSplit::Range::Of::parts) {
      for (std::uint64_t part = range.begin; part < range.begin + range.count; ++part)
        units.push_back({range.file, part, in_parts});
    } else if (!in_parts) {
      units.push_back({range.file, {}, false});
    } else {
      for (std::uint64_t part = 0; part < file.parts; ++part) units.push_back({range.file, part, true});
    }
  }
  return units;
}

// Calls `sink` with the points of a unit that the filter keeps, and counts them. The unit's ids begin at first_id.
Status read_unit(PointReader& reader, const Unit& unit, const PointFilter& filter, std::uint64_t first_id,
                 CloudCounts& counts, const Sink& sink) {
  PointBatch batch;
  CloudBatch kept;
  if (unit.begin > 0) {
    BOOST_OUTCOME_TRYV(reader.seek(unit.begin));
  }
  const bool range = unit.count != UINT64_MAX;
  for (std::uint64_t left = unit.count;; left -= batch.points.size()) {
    if (left == 0) {  // at the end of a file readers check that it is still the file that was opened
      BOOST_OUTCOME_TRYV(reader.seek(UINT64_MAX));
      return reader.next(batch, 1);
    }
    batch.passed_over = 0;
    BOOST_OUTCOME_TRYV(reader.next(batch, std::min<std::uint64_t>(left, SIZE_MAX)));
    counts.read += batch.passed_over;
    counts.filtered += batch.passed_over;
    if (batch.points.empty() && range)
      return error(Errc::bad_input, reader.info().path.string() + ": was changed by another program while it was read");
    if (batch.points.empty()) return success();
    kept.points.clear();
    kept.rows.clear();
    BOOST_OUTCOME_TRYV(filter.apply(batch, reader, first_id + counts.read, kept, counts));
    if (!kept.points.empty()) {
      BOOST_OUTCOME_TRYV(sink(kept));
    }
  }
}

// The same, with another thread that reads while this thread is in `sink`.
Status read_unit_ahead(PointReader& reader, const Unit& unit, const PointFilter& filter, std::uint64_t first_id,
                       CloudCounts& counts, const Sink& sink) {
  BatchQueue queue;
  const auto read = [&]() -> Status {
    try {
      return read_unit(reader, unit, filter, first_id, counts, [&](CloudBatch& batch) -> Status {
        if (queue.push(batch)) return success();
        return error(Errc::interrupted, "the batches are not wanted any more");
      });
    } catch (const std::bad_alloc&) {
      return worded([&] { return error(Errc::memory, "no memory is left to read " + reader.info().path.string()); });
    }
  };
  const std::jthread thread([&] { queue.finish(read()); });
  struct Closing {
    ~Closing() { queue.close(); }
    BatchQueue& queue;
  } const closing{queue};
  CloudBatch batch;
  while (queue.pop(batch)) {
    BOOST_OUTCOME_TRYV(sink(batch));
  }
  return queue.status();
}

struct ReadUnit {
  std::vector<CloudBatch> batches;  // their ids begin at 0
  CloudCounts counts;
};

}  // namespace

Result<CloudCounts> Cloud::for_each_batch(const std::function<Status(CloudBatch&)>& visit) const {
  return for_each_batch(whole(), visit);
}

Result<CloudCounts> Cloud::for_each_batch(const InputSplit& split, const std::function<Status(CloudBatch&)>& visit,
                                          std::vector<std::uint64_t>* of_files) const {
  const PointFilter filter(options_, schema_);
  const std::vector<Unit> units = units_of(split, files_, filter.reader_schema());
  CloudCounts counts;
  if (of_files != nullptr) of_files->assign(files_.size(), 0);
  const auto read_whole = [&](const Unit& unit, bool count_lines) -> Result<ReadUnit> {
    ReadUnit made;
    const ReadHints hints{.threads = 1, .part = unit.part, .count_lines = count_lines};
    BOOST_OUTCOME_TRY(reader, reopen(unit.file, filter.reader_schema(), hints));
    BOOST_OUTCOME_TRYV(read_unit(*reader, unit, filter, 0, made.counts, [&](CloudBatch& batch) -> Status {
      made.batches.push_back(std::move(batch));
      batch = {};
      return success();
    }));
    return made;
  };
  const auto read_ahead = [&](std::size_t i) -> Result<ReadUnit> {
    if (!units[i].ahead) return ReadUnit{};
    auto made = read_whole(units[i], false);
    // Lines are counted only for an error, because counting takes time.
    if (made.has_error() && units[i].part.value_or(0) > 0) return read_whole(units[i], true);
    return made;
  };
  const auto deliver = [&](std::size_t i, ReadUnit made) -> Status {
    for (auto& batch : made.batches) {
      for (auto& p : batch.points) p.id.value += counts.read;
      BOOST_OUTCOME_TRYV(visit(batch));
    }
    if (!units[i].ahead) {
      const ReadHints hints{
          .threads = options_.threads, .part = units[i].part, .count_lines = units[i].part.value_or(0) > 0};
      BOOST_OUTCOME_TRY(reader, reopen(units[i].file, filter.reader_schema(), hints));
      const auto read = options_.threads > 1 ? read_unit_ahead : read_unit;
      BOOST_OUTCOME_TRYV(read(*reader, units[i], filter, counts.read, made.counts, visit));
    }
    counts.add(made.counts);
    if (of_files != nullptr) (*of_files)[units[i].file] += made.counts.read;
    return success();
  };
  BOOST_OUTCOME_TRYV(in_order(units.size(), options_.threads, read_ahead, deliver));
  return counts;
}

}  // namespace tessera

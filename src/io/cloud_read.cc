// Cloud::for_each_batch. Batches are delivered in the order of the input, since ids, tile files and the choice of seeds
// rest on it; the threads only read ahead.
#include <cstdint>
#include <functional>
#include <new>
#include <thread>
#include <utility>
#include <vector>

#include "src/io/batch_queue.h"
#include "src/io/cloud.h"
#include "src/io/in_order.h"
#include "src/io/point_filter.h"
#include "src/io/record_stream.h"

namespace tessera {
namespace {

using Sink = std::function<Status(CloudBatch&)>;

// A file that is read ahead as a whole. What its header promises is checked when it is opened; text holds no more
// points than two bytes each.
constexpr std::uint64_t small_text_bytes = std::uint64_t{1} << 20;
constexpr std::uint64_t small_rows_bytes = std::uint64_t{8} << 20;

bool is_small(const FileInfo& file, const std::vector<Attribute>& schema) {
  if (!file.points) return file.content_bytes <= small_text_bytes;
  return *file.points <= batch_points_max && *file.points * row_bytes(schema) <= small_rows_bytes;
}

// Gives `sink` what the filter keeps of a file whose points have ids from first_id on, and counts it.
Status read_file(PointReader& reader, const PointFilter& filter, std::uint64_t first_id, CloudCounts& counts,
                 const Sink& sink) {
  PointBatch batch;
  CloudBatch kept;
  while (true) {
    batch.passed_over = 0;
    BOOST_OUTCOME_TRYV(reader.next(batch));
    counts.read += batch.passed_over;
    counts.filtered += batch.passed_over;
    if (batch.points.empty()) return success();
    kept.points.clear();
    kept.rows.clear();
    BOOST_OUTCOME_TRYV(filter.apply(batch, reader, first_id + counts.read, kept, counts));
    if (!kept.points.empty()) {
      BOOST_OUTCOME_TRYV(sink(kept));
    }
  }
}

// The same with another thread that reads while this one is in `sink`.
Status read_file_ahead(PointReader& reader, const PointFilter& filter, std::uint64_t first_id, CloudCounts& counts,
                       const Sink& sink) {
  BatchQueue queue;
  const auto read = [&]() -> Status {
    try {
      return read_file(reader, filter, first_id, counts, [&](CloudBatch& batch) -> Status {
        if (queue.push(batch)) return success();
        return error(Errc::interrupted, "nobody wants the batches any more");
      });
    } catch (const std::bad_alloc&) {
      return error(Errc::memory, "no memory is left to read " + reader.info().path.string());
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

struct SmallFile {
  std::vector<CloudBatch> batches;  // with ids from 0 on
  CloudCounts counts;
};

}  // namespace

Result<CloudCounts> Cloud::for_each_batch(const std::function<Status(CloudBatch&)>& visit) const {
  const PointFilter filter(options_, schema_);
  CloudCounts counts;
  const auto add = [&](const CloudCounts& of_file) {
    counts.read += of_file.read;
    counts.invalid += of_file.invalid;
    counts.filtered += of_file.filtered;
  };
  const auto read_small = [&](std::size_t i) -> Result<SmallFile> {
    SmallFile file;
    if (!is_small(files_[i], filter.reader_schema())) return file;
    BOOST_OUTCOME_TRY(reader, reopen(i, filter.reader_schema(), 1));
    BOOST_OUTCOME_TRYV(read_file(*reader, filter, 0, file.counts, [&](CloudBatch& batch) -> Status {
      file.batches.push_back(std::move(batch));
      batch = {};
      return success();
    }));
    return file;
  };
  const auto deliver = [&](std::size_t i, SmallFile file) -> Status {
    if (is_small(files_[i], filter.reader_schema())) {
      for (auto& batch : file.batches) {
        for (auto& p : batch.points) p.id += counts.read;
        BOOST_OUTCOME_TRYV(visit(batch));
      }
      add(file.counts);
      return success();
    }
    BOOST_OUTCOME_TRY(reader, reopen(i, filter.reader_schema(), options_.threads));
    CloudCounts of_file;
    const auto read = options_.threads > 1 ? read_file_ahead : read_file;
    BOOST_OUTCOME_TRYV(read(*reader, filter, counts.read, of_file, visit));
    add(of_file);
    return success();
  };
  BOOST_OUTCOME_TRYV(in_order(files_.size(), options_.threads, read_small, deliver));
  return counts;
}

}  // namespace tessera

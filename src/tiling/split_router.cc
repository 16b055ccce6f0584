#include "src/tiling/split_router.h"

#include <span>
#include <string>

#include "src/base/files/checksum.h"
#include "src/base/files/frame.h"
#include "src/base/files/names.h"
#include "src/tiling/budget/budget.h"
#include "src/tiling/tile_writer.h"

namespace tessera {
namespace {

// Marks the file of an input split. There is no plan yet, so the partition and the attempt identify it.
FrameOwner owner_of(const Partition& partition, std::uint32_t attempt) {
  const std::string text = partition.to_json();
  return {checksum(std::as_bytes(std::span(text))), attempt};
}

}  // namespace

Status write_split(const Cloud& cloud, const InputSplit& split, const Partition& partition, TileWriter& writer,
                   const std::stop_token& stop, const RoutedMore& more) {
  RoutedPoints& routed = writer.routed();
  routed.resize(partition.tiles());
  const auto visit = [&](CloudBatch& batch) -> Status {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while points were routed");
    BOOST_OUTCOME_TRYV(writer.add(partition, batch.points, batch.rows));
    routed.span.add(batch.points);
    more(batch.points.size());
    return success();
  };
  BOOST_OUTCOME_TRY(counts, cloud.for_each_batch(split, visit, &routed.of_files));
  routed.counts = counts;
  return writer.flush(partition);
}

Status route_split(const Cloud& cloud, const InputSplit& split, const Partition& partition, const SplitWork& work,
                   const std::stop_token& stop) {
  TileWriter writer(work.run_folder, work.attempt, partition.dimension(), row_bytes(cloud.schema()),
                    budget::route_buffer_bytes(work.memory_bytes), partition.period());
  BOOST_OUTCOME_TRYV(write_split(cloud, split, partition, writer, stop, work.routed));
  return write_frame(routed_split_file(work.run_folder, work.attempt), ScratchKind::split,
                     owner_of(partition, work.attempt), to_bytes(writer.routed()));
}

Result<RoutedPoints> read_split(const std::filesystem::path& run_folder, std::uint32_t attempt,
                                const Partition& partition) {
  const auto path = routed_split_file(run_folder, attempt);
  BOOST_OUTCOME_TRY(bytes, read_frame(path, ScratchKind::split, owner_of(partition, attempt)));
  RoutedPoints routed(partition.dimension(), partition.period());
  if (!from_bytes(bytes, partition.tiles(), routed))
    return damaged_run(path, "is not a valid list of the points that were routed");
  return routed;
}

}  // namespace tessera

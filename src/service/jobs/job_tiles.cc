#include "src/service/jobs/job_tiles.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include "src/base/phases.h"
#include "src/tiling/partition.h"

namespace tessera::service {
namespace {

constexpr char letter(TileStatus stage) { return static_cast<char>(stage); }

constexpr std::size_t parts_of_time = 240;  // as many as a curve on a page shows

void tell_layout(const TileLayout& layout, proto::TileLayout& told) {
  told.set_dimension(layout.dimension);
  if (!layout.bounds.empty()) {
    for (const Point& corner : {layout.bounds.lo, layout.bounds.hi})
      for (int axis = 0; axis < 3; ++axis) told.add_bounds(corner[axis]);
  }
  for (const TileCut& cut : layout.cuts) {
    told.add_axis(cut.axis);
    told.add_place(cut.at);
    told.add_below(cut.below);
    told.add_above(cut.above);
  }
}

void tell_mail(const std::vector<MailArc>& arcs, proto::JobTiles& tiles) {
  for (const MailArc& arc : arcs) {
    proto::TileMail& mail = *tiles.mutable_mail();
    mail.add_from(arc.from);
    mail.add_to(arc.to);
    mail.add_points(arc.bytes / sizeof(SharedPoint));
  }
}

}  // namespace

void tell_running(const Progress& progress, bool with_layout, proto::JobTiles& tiles) {
  const PhaseRow& phase = row_of(progress.phase);  // before the stages: what is settled stays settled
  std::string stages = progress.map.stages();
  if (phase.settled) {
    for (char& stage : stages)
      if (stage != letter(TileStatus::empty) && stage != letter(TileStatus::stored))
        stage = letter(TileStatus::settled);
  }
  tiles.set_stages(std::move(stages));
  tiles.set_begun_again(progress.map.begun_again());
  if (phase.exchanges) tell_mail(progress.mail.heaviest(), tiles);
  tiles.set_elapsed_s(std::chrono::duration<double>(std::chrono::steady_clock::now() - progress.started).count());
  const BusyThreads busy = progress.busy(parts_of_time);
  tiles.mutable_busy_threads()->Add(busy.threads.begin(), busy.threads.end());
  tiles.set_busy_s(busy.until_s);
  if (with_layout && !tiles.stages().empty()) tell_layout(progress.map.layout(), *tiles.mutable_layout());
}

Status tell_stored(const Manifest& manifest, bool with_layout, proto::JobTiles& tiles) {
  std::string stages(std::max<std::size_t>(1, manifest.boxes.size()), letter(TileStatus::empty));
  for (const TileEntry& entry : manifest.tiles) {
    if (entry.tile.value < stages.size()) stages[entry.tile.value] = letter(TileStatus::stored);
  }
  tiles.set_stages(std::move(stages));
  for (const auto& [phase, seconds] : manifest.seconds) tiles.set_elapsed_s(tiles.elapsed_s() + seconds);
  if (!with_layout) return success();
  BOOST_OUTCOME_TRY(partition, Partition::from_json(manifest.partition));
  tell_layout(layout_of(partition, manifest.bounds), *tiles.mutable_layout());
  return success();
}

}  // namespace tessera::service

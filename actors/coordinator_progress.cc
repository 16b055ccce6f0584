// What the owner of a job is told of its way: the parts' words added up.
#include <utility>

#include "actors/coordinator.h"

namespace tessera {

void Coordinator::show_progress(PartProgress& message) {
  if (!has(message.node)) return;
  untold_.insert(untold_.end(), message.spans.begin(), message.spans.end());
  untold_mail_.insert(untold_mail_.end(), message.mail.begin(), message.mail.end());
  parts_.at(message.node.value).progress = std::move(message);
  parts_.at(message.node.value).progress.spans.clear();
  parts_.at(message.node.value).progress.mail.clear();
  // Of many nodes an eighth speak before all are added up: else their words would cost the square of their number.
  if (++spoken_ >= parts_.size() / 8) tell_progress();
}

void Coordinator::tell_progress() {
  spoken_ = 0;
  count_tiles();
  RunProgress progress;
  progress.sum.spans = std::exchange(untold_, {});
  progress.sum.mail = std::exchange(untold_mail_, {});
  progress.nodes_lost = nodes_lost_;
  progress.stage = quiet_ ? RunStage::collecting : begun_ ? RunStage::splaying : RunStage::triangulating;
  for (const PartOf& p : parts_) {
    PartProgress now = p.progress;
    if (p.lost) {  // what it has stored stays so; the rest is done again
      now.tiles_begun = now.tiles_stored;
      now.points_begun = now.tiles_asleep = now.memory_bytes = 0;
    }
    progress.sum.tiles_begun += now.tiles_begun;
    progress.sum.points_begun += now.points_begun;
    progress.sum.tiles_stored += now.tiles_stored;
    progress.sum.tiles_asleep += now.tiles_asleep;
    progress.sum.updates_sent += now.updates_sent;
    progress.sum.updates_processed += now.updates_processed;
    progress.sum.points_sent += now.points_sent;
    progress.sum.memory_bytes += now.memory_bytes;
    progress.sum.gates += now.gates;
    if (p.name.empty()) continue;
    progress.nodes.push_back({p.name, p.tiles, static_cast<std::uint32_t>(now.tiles_begun),
                              static_cast<std::uint32_t>(now.tiles_stored), now.memory_bytes, p.lost && !p.left});
  }
  owner_.progressed(progress);
}

void Coordinator::count_tiles() {
  if (counted_ == table_.epoch) return;
  counted_ = table_.epoch;
  for (PartOf& p : parts_) p.tiles = 0;
  for (const TileId t : options_.order) {
    if (const NodeId node = table_.node_of(t); node.value < parts_.size()) ++parts_[node.value].tiles;
  }
}

}  // namespace tessera

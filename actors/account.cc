#include "actors/account.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

std::uint64_t microseconds(std::chrono::steady_clock::duration time) {
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(time).count());
}

}  // namespace

void Account::start(Time now, bool settled) {
  started_ = now;
  if (settled) begun_ = quiet_ = now;
}

RunStep Account::step() const { return quiet_ ? RunStep::ending : begun_ ? RunStep::exchanging : RunStep::beginning; }

StageTimes Account::times(Time now) const {
  return {microseconds(begun_.value_or(now) - started_), microseconds(quiet_.value_or(now) - begun_.value_or(now)),
          microseconds(now - quiet_.value_or(now))};
}

void Account::begin_stage(Time now) {
  before_.push_back(times(now));
  before_.reserve(before_.size() + 1);
  started_ = now;
  begun_.reset();
  quiet_.reset();
}

bool Account::heard(NodeId node, ShareProgress said, std::size_t nodes) {
  untold_.insert(untold_.end(), said.spans.begin(), said.spans.end());
  untold_mail_.insert(untold_mail_.end(), said.mail.begin(), said.mail.end());
  said.spans.clear();
  said.mail.clear();
  if (said_.size() <= node.value) said_.resize(node.value + 1);
  said_[node.value] = std::move(said);
  return ++spoken_ >= nodes / 8;
}

RunProgress Account::progress(const std::vector<Node>& nodes) {
  spoken_ = 0;
  RunProgress progress;
  progress.sum.spans = std::exchange(untold_, {});
  progress.sum.mail = std::exchange(untold_mail_, {});
  progress.nodes_lost = nodes_lost_;
  progress.stage = static_cast<std::uint32_t>(before_.size());
  progress.step = step();
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Node& node = nodes[n];
    ShareProgress now = n < said_.size() ? said_[n] : ShareProgress{};
    if (node.lost) {  // what the node has stored stays; the rest is done again
      now.tiles_begun = now.tiles_stored;
      now.weight_begun = now.tiles_asleep = now.memory_bytes = 0;
    }
    progress.sum.tiles_begun += now.tiles_begun;
    progress.sum.weight_begun += now.weight_begun;
    progress.sum.tiles_stored += now.tiles_stored;
    progress.sum.tiles_asleep += now.tiles_asleep;
    progress.sum.updates_sent += now.updates_sent;
    progress.sum.updates_processed += now.updates_processed;
    progress.sum.items_sent += now.items_sent;
    progress.sum.memory_bytes += now.memory_bytes;
    progress.sum.outboxes += now.outboxes;
    if (node.name.empty()) continue;
    progress.nodes.push_back({node.name, node.tiles, static_cast<std::uint32_t>(now.tiles_begun),
                              static_cast<std::uint32_t>(now.tiles_stored), now.memory_bytes, node.lost && !node.left});
  }
  return progress;
}

void Account::ended(const ShareEnded& share) {
  sum_.items += share.items;
  sum_.updates += share.updates;
  sum_.hops = std::max(sum_.hops, share.hops);
  sum_.most_received = std::max(sum_.most_received, share.most_received);
  sum_.sleeps += share.sleeps;
  sum_.outboxes += share.outboxes;
  sum_.begin_us += share.begin_us;
  sum_.exchange_us += share.exchange_us;
  sum_.collect_us += share.collect_us;
}

RunEnded Account::end(Time now, std::uint64_t waves) {
  RunEnded end;
  end.waves = waves;
  end.nodes = nodes_;
  end.nodes_lost = nodes_lost_;
  end.tiles_again = tiles_again_;
  end.sum = std::move(sum_);
  before_.push_back(times(now));
  end.stages = std::move(before_);
  return end;
}

}  // namespace tessera

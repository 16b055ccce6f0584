#include "src/cluster/members.h"

#include <algorithm>

namespace tessera {

bool Members::hello(const MemberInfo& info, const NodeUse& use, Time now) {
  if (lost_.contains(info.uuid)) return false;
  Member& member = members_[info.uuid];
  if (member.number == 0) {
    member.number = ++numbers_;
    member.came = now;
  }
  member.info = info;
  member.use = use;
  member.heard = now;
  return true;
}

bool Members::mark_reached_all(const NodeUuid& uuid) {
  const bool broken = std::any_of(broken_.begin(), broken_.end(),
                                  [&](const auto& pair) { return pair.first == uuid || pair.second == uuid; });
  if (broken) return false;
  const auto found = members_.find(uuid);
  return found != members_.end() && !std::exchange(found->second.free, true);
}

bool Members::renew(const NodeUuid& uuid, const NodeUse& use, Time now) {
  const auto found = members_.find(uuid);
  if (found == members_.end()) return false;
  found->second.heard = now;
  found->second.use = use;
  return true;
}

void Members::note_unreachable(const NodeUuid& from, const NodeUuid& to, Time now) {
  if (from == to || !members_.contains(from) || !members_.contains(to)) return;
  broken_.insert(std::minmax(from, to));
  if (!broken_since_) broken_since_ = now;
}

std::optional<Members::Loss> Members::lose(const NodeUuid& uuid, std::string why) {
  const auto found = members_.find(uuid);
  if (found == members_.end()) return std::nullopt;
  Loss loss{std::move(found->second), std::move(why)};
  members_.erase(found);
  lost_.insert(uuid);
  std::erase_if(broken_, [&](const auto& pair) { return pair.first == uuid || pair.second == uuid; });
  if (broken_.empty()) broken_since_.reset();
  return loss;
}

// Returns the node with most broken connections; of equal ones, the last that came.
NodeUuid Members::worst_connected() const {
  std::map<NodeUuid, std::uint64_t> count;
  for (const auto& [a, b] : broken_) {
    ++count[a];
    ++count[b];
  }
  const auto rank = [&](const auto& entry) { return std::pair(entry.second, members_.at(entry.first).number); };
  return std::max_element(count.begin(), count.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); })
      ->first;
}

std::vector<Members::Loss> Members::lose_silent(Time now) {
  std::vector<Loss> losses;
  const Duration usual = lease_ / 4;
  if (asked_ && now - *asked_ > usual) {
    for (auto& [uuid, member] : members_) member.heard += now - *asked_ - usual;
  }
  asked_ = now;
  std::vector<NodeUuid> silent;
  for (const auto& [uuid, member] : members_) {
    if (now - member.heard > lease_) silent.push_back(uuid);
  }
  for (const NodeUuid& uuid : silent) losses.push_back(*lose(uuid, "has been silent for longer than its lease"));
  if (broken_since_ && now - *broken_since_ >= lease_ / 8) {
    while (!broken_.empty()) losses.push_back(*lose(worst_connected(), "cannot be reached by other nodes"));
  }
  return losses;
}

const Members::Member* Members::find(const NodeUuid& uuid) const {
  const auto found = members_.find(uuid);
  return found == members_.end() ? nullptr : &found->second;
}

}  // namespace tessera

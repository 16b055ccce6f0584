#include "src/exchange/inquiry.h"

#include <algorithm>
#include <utility>

namespace tessera {

Inquiry::Question Inquiry::ask() {
  open_.push_back(true);
  return open_.size() - 1;
}

void Inquiry::take(Question question, Answer answer) {
  open_.at(question) = false;
  answers_.push_back({question, std::move(answer)});
}

bool Inquiry::is_answered(Question question) const {
  return std::any_of(answers_.begin(), answers_.end(),
                     [&](const Answered& answered) { return answered.question == question; });
}

Inquiry::Lost Inquiry::lose(Question question) {
  if (open_.at(question)) {
    open_[question] = false;
    return Lost::question;
  }
  const auto erased = std::erase_if(answers_, [&](const Answered& answered) {
    if (answered.question != question) return false;
    if (answered.answer.has_share) numbers_lost_ = std::max(numbers_lost_, answered.answer.self.value + 1);
    return true;
  });
  return erased > 0 ? Lost::answer : Lost::nothing;
}

void Inquiry::end_share(NodeId self) {
  for (Answered& answered : answers_) {
    if (answered.answer.has_share && answered.answer.self == self) answered.answer.has_share = false;
  }
}

bool Inquiry::waits() const { return std::find(open_.begin(), open_.end(), true) != open_.end(); }

std::optional<RoutingTable> Inquiry::newest(const RoutingTable& present) const {
  const Answer* with_newest = nullptr;
  bool any = false;
  Epoch epoch = present.epoch;
  for (const Answered& answered : answers_) {
    if (!answered.answer.has_share) continue;
    any = true;
    if (answered.answer.table.epoch < epoch) continue;
    epoch = answered.answer.table.epoch;
    with_newest = &answered.answer;
  }
  if (!any) return std::nullopt;
  return with_newest ? with_newest->table : present;
}

std::uint32_t Inquiry::numbers(const std::optional<RoutingTable>& table) const {
  std::uint32_t numbers = numbers_lost_;
  if (!table) return numbers;
  for (const Answered& answered : answers_) {
    if (answered.answer.has_share) numbers = std::max(numbers, answered.answer.self.value + 1);
  }
  for (const NodeId node : table->nodes) numbers = std::max(numbers, node.value + 1);
  return numbers;
}

std::vector<bool> Inquiry::given_up(const RoutingTable& table, std::size_t tiles) const {
  std::vector<bool> given_up(tiles);
  for (const Answered& answered : answers_) {
    for (const TileId t : answered.answer.released) given_up.at(t.value) = table.node_of(t) == answered.answer.self;
  }
  return given_up;
}

}  // namespace tessera

#include "src/exchange/outboxes.h"

#include <algorithm>

#include "src/base/files/names.h"

namespace tessera {

Outboxes::Outboxes(const OutboxOptions& options, std::filesystem::path scratch)
    : options_(options), scratch_(std::move(scratch)) {}

Status Outboxes::add(NodeId to, Update update) {
  return outboxes_.try_emplace(to, options_, scratch_.empty() ? scratch_ : outbox_scratch_file(scratch_, to))
      .first->second.add(std::move(update));
}

Result<std::vector<Update>> Outboxes::next(NodeId to) { return outboxes_.at(to).next(); }

bool Outboxes::taken(NodeId by, std::uint64_t bytes) {
  const auto outbox = outboxes_.find(by);
  if (outbox == outboxes_.end()) return false;
  outbox->second.taken(bytes);
  return true;
}

void Outboxes::clear() noexcept {
  for (auto& [node, outbox] : outboxes_) outbox.clear();
}

OutboxCounts Outboxes::counts() const {
  OutboxCounts sum;
  for (const auto& [node, outbox] : outboxes_) sum += outbox.counts();
  return sum;
}

std::uint64_t Outboxes::waiting_bytes() const {
  std::uint64_t sum = 0;
  for (const auto& [node, outbox] : outboxes_) sum += outbox.waiting_bytes();
  return sum;
}

bool EarlyMail::keep(NodeId from, Update update, std::size_t nodes) {
  bytes_ += Outbox::bytes_of(update);
  early_.push_back({from, std::move(update)});
  return bytes_ <= 2 * std::max<std::size_t>(nodes, 8) * in_flight_max;
}

}  // namespace tessera

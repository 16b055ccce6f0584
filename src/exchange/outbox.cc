#include "src/exchange/outbox.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "src/base/files/frame.h"
#include "src/base/files/whole_file.h"
#include "src/base/flat_codec.h"
#include "src/exchange/update_bytes.h"

namespace tessera {

OutboxOptions outboxes_within(std::uint64_t bytes, std::uint64_t peers) {
  const OutboxOptions most;
  OutboxOptions out;
  const std::uint64_t each = bytes / 2 / std::max<std::uint64_t>(1, peers);
  out.packet_bytes = std::clamp<std::uint64_t>(each / 2, 64 << 10, most.packet_bytes);
  out.window_bytes = std::clamp(each, 2 * out.packet_bytes, most.window_bytes);
  out.memory_bytes = std::min(each, most.memory_bytes);
  return out;
}

Outbox::Outbox(const OutboxOptions& options, std::filesystem::path scratch)
    : options_(options), scratch_(std::move(scratch)) {}

Outbox::~Outbox() { clear(); }

void Outbox::clear() noexcept {
  held_.clear();
  spilled_.clear();
  held_bytes_ = spilled_bytes_ = in_flight_ = 0;
  if (end_ > 0) {
    std::error_code left;  // a file that stays is removed with its folder
    std::filesystem::remove(scratch_, left);
    end_ = 0;
  }
}

Status Outbox::add(Update update) {
  held_bytes_ += bytes_of(update);
  held_.push_back(std::move(update));
  return held_bytes_ > options_.memory_bytes && !scratch_.empty() ? spill() : success();
}

// Removes and returns the oldest updates that fit into one packet, and at least one.
std::vector<Update> Outbox::cut() {
  std::vector<Update> packet;
  std::uint64_t bytes = 0;
  while (!held_.empty()) {
    const std::uint64_t more = bytes_of(held_.front());
    if (!packet.empty() && bytes + more > options_.packet_bytes) break;
    bytes += more;
    packet.push_back(std::move(held_.front()));
    held_.pop_front();
  }
  held_bytes_ -= bytes;
  return packet;
}

Status Outbox::spill() {
  while (!held_.empty()) {
    FlatWriter out;
    std::uint64_t bytes = 0;
    for (const Update& update : cut()) {
      bytes += bytes_of(update);
      put(out, update);
    }
    const auto payload = out.take();
    BOOST_OUTCOME_TRYV(append_frame(scratch_, ScratchKind::mail, {}, payload));
    spilled_.push_back({end_, bytes});
    spilled_bytes_ += bytes;
    end_ += frame_header_bytes + payload.size();
  }
  return success();
}

Result<std::vector<Update>> Outbox::next() {
  std::vector<Update> packet;
  if (waiting_bytes() == 0) return packet;
  const std::uint64_t bytes = spilled_.empty()
                                  ? std::min(std::max(bytes_of(held_.front()), options_.packet_bytes), held_bytes_)
                                  : spilled_.front().bytes;
  // The receiver may hold back held_back() bytes without giving credit, so that much under way counts as nothing.
  // Otherwise an update larger than the rest of the window would wait for ever.
  if (in_flight_ > held_back(options_.window_bytes) && in_flight_ + bytes > options_.window_bytes) {
    if (!std::exchange(waits_, true)) ++counts_.waits;
    return packet;
  }
  waits_ = false;
  if (spilled_.empty()) {
    packet = cut();
  } else {
    BOOST_OUTCOME_TRY(payload, read_frame_at(scratch_, ScratchKind::mail, {}, spilled_.front().at));
    FlatReader in(payload);
    bool sound = true;
    while (sound && !in.at_end()) sound = get(in, packet.emplace_back());
    if (!sound)
      return error(Errc::corrupt,
                   scratch_.string() + ": is damaged: it does not hold the updates that were written to it");
    spilled_bytes_ -= spilled_.front().bytes;
    spilled_.pop_front();
    if (spilled_.empty()) {
      BOOST_OUTCOME_TRYV(remove_file(scratch_));
      end_ = 0;
    }
  }
  std::uint64_t sent = 0;
  for (const Update& update : packet) sent += bytes_of(update);
  in_flight_ += sent;
  counts_.bytes += sent;
  ++counts_.packets;
  return packet;
}

}  // namespace tessera

// What waits to be sent to one other node of a job, with flow control. An outbox does no I/O but for its scratch file:
// it is told what there is to send and what the other node has taken, and says what may be sent now. Not thread-safe.
//
// A window bounds the bytes that were sent and are neither in the mail of their tiles nor dropped at the other node. So
// a slow node slows down the nodes that send to it, and no node runs out of memory. The other node gives credit once
// for each held_back() bytes, not for every packet. What waits meanwhile is held in memory up to a bound, and then on
// scratch. Receiving never waits for sending, so nodes cannot wait for each other in a circle.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <vector>

#include "src/base/result.h"
#include "src/exchange/update.h"

namespace tessera {

struct OutboxOptions {
  std::uint64_t window_bytes = std::uint64_t{32} << 20;
  std::uint64_t packet_bytes = std::uint64_t{1} << 20;  // size of a packet; a larger update is a packet of its own
  std::uint64_t memory_bytes = std::uint64_t{8} << 20;  // of what waits; more goes to scratch
};

// Returns the options for a node that sends to `peers` others within `bytes` of memory. One half is for what it has
// received and not yet given to tiles, the other half for what waits to be sent. With many peers the lower bounds of
// packet and window exceed `bytes`.
OutboxOptions outboxes_within(std::uint64_t bytes, std::uint64_t peers);

// More bytes than a node that keeps to the largest window ever has under way to another one.
inline constexpr std::uint64_t in_flight_max = OutboxOptions{}.window_bytes + 4 * OutboxOptions{}.packet_bytes;

struct OutboxCounts {
  std::uint64_t packets = 0, bytes = 0;  // sent
  std::uint64_t waits = 0;               // times that something had to wait for the window
  OutboxCounts& operator+=(const OutboxCounts& other) {
    packets += other.packets;
    bytes += other.bytes;
    waits += other.waits;
    return *this;
  }
};

class Outbox {
 public:
  // Returns for how many bytes an update counts: about what it takes on the wire and in memory.
  static std::uint64_t bytes_of(const Update& update) { return 64 + update.message.size(); }

  // `scratch` names a file that this object alone uses. When the path is empty, everything that waits is held in
  // memory.
  Outbox(const OutboxOptions& options, std::filesystem::path scratch);
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;
  ~Outbox();

  // Appends an update. Error io.
  Status add(Update update);
  // Returns the next packet, in the order in which updates were added. The packet is empty when nothing waits or while
  // the window is full. Errors io, corrupt.
  Result<std::vector<Update>> next();
  // How many bytes the receiver may take before it must give credit.
  static std::uint64_t held_back(std::uint64_t window_bytes) { return window_bytes / 4; }

  // The other node has taken `bytes` of what was sent.
  void taken(std::uint64_t bytes) { in_flight_ -= std::min(bytes, in_flight_); }
  // Forgets all that waits, as the other node is gone.
  void clear() noexcept;

  const OutboxCounts& counts() const { return counts_; }
  std::uint64_t waiting_bytes() const { return held_bytes_ + spilled_bytes_; }

 private:
  struct Spilled {
    std::uint64_t at = 0, bytes = 0;
  };
  Status spill();
  std::vector<Update> cut();

  OutboxOptions options_;
  std::filesystem::path scratch_;
  std::deque<Update> held_;
  std::deque<Spilled> spilled_;  // in the scratch file; older than those in held_
  std::uint64_t held_bytes_ = 0, spilled_bytes_ = 0, in_flight_ = 0, end_ = 0;
  bool waits_ = false;
  OutboxCounts counts_;
};

}  // namespace tessera

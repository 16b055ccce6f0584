// What waits to be sent to one other node of a job. Pure but for its scratch: told what there is and what has been
// taken there, it says what may be sent now.
//
// Of what has been sent, no more than a window of bytes may be neither in the mail of its tiles nor dropped there: a
// slow node slows down those who talk to it, and nobody runs out of memory. The other one says so when it comes to
// held_back() bytes, not for every parcel. What waits meanwhile is held in memory up to a bound, and then on scratch.
// Receiving never waits for sending, so nodes cannot wait for each other in a circle.
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
  std::uint64_t parcel_bytes = std::uint64_t{1} << 20;  // sent at once; a single update may have more
  std::uint64_t memory_bytes = std::uint64_t{8} << 20;  // of what waits
};

// Those of a node that talks to `peers` others: what it has received and not given to tiles yet, and what waits to be
// sent, each in half of `bytes`.
OutboxOptions outboxes_within(std::uint64_t bytes, std::uint64_t peers);

// More than a node that keeps to the largest window ever has under way to another one.
inline constexpr std::uint64_t in_flight_max = OutboxOptions{}.window_bytes + 4 * OutboxOptions{}.parcel_bytes;

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
  // What it counts for: about what it takes on the wire and in memory.
  static std::uint64_t bytes_of(const Update& update) { return 64 + update.message.size(); }

  // `scratch`: a file that is its own; none: everything that waits is held in memory.
  Outbox(const OutboxOptions& options, std::filesystem::path scratch);
  Outbox(const Outbox&) = delete;
  Outbox& operator=(const Outbox&) = delete;
  ~Outbox();

  // Error io.
  Status add(Update update);
  // What may be sent now, in the order in which it came; nothing while the window is full. Errors io, corrupt.
  Result<std::vector<Update>> next();
  static std::uint64_t held_back(std::uint64_t window_bytes) { return window_bytes / 4; }

  // So many of the bytes sent have been taken there.
  void taken(std::uint64_t bytes) { in_flight_ -= std::min(bytes, in_flight_); }
  // Nobody is there any more.
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
  std::deque<Spilled> spilled_;  // came before those held
  std::uint64_t held_bytes_ = 0, spilled_bytes_ = 0, in_flight_ = 0, end_ = 0;
  bool waits_ = false;
  OutboxCounts counts_;
};

}  // namespace tessera

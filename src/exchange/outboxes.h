// What a share sends to the other nodes of a job, and the credit that it owes them for what they send
// (src/exchange/outbox.h). Plain objects without I/O but for the scratch files of the outboxes. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "src/base/ids.h"
#include "src/base/result.h"
#include "src/exchange/outbox.h"
#include "src/exchange/update.h"

namespace tessera {

// The outboxes of a share, one for each node to which it has sent something.
class Outboxes {
 public:
  // `scratch` is a folder of these outboxes alone. When the path is empty, everything that waits is held in memory.
  Outboxes(const OutboxOptions& options, std::filesystem::path scratch);

  // Appends an update for a node. Error io.
  Status add(NodeId to, Update update);
  // Returns the next packet for a node, as Outbox::next() does. REQUIRES: an update was added for the node before.
  Result<std::vector<Update>> next(NodeId to);
  // A node has taken `bytes` of what was sent there. Returns false when nothing was ever sent to it.
  bool taken(NodeId by, std::uint64_t bytes);
  // Forgets all that waits for nodes for which `has_share(NodeId)` is false.
  template <class HasShare>
  void clear_unless(const HasShare& has_share) {
    for (auto& [node, outbox] : outboxes_) {
      if (!has_share(node)) outbox.clear();
    }
  }
  void clear() noexcept;

  std::uint64_t window_bytes() const { return options_.window_bytes; }
  OutboxCounts counts() const;
  std::uint64_t waiting_bytes() const;

 private:
  OutboxOptions options_;
  std::filesystem::path scratch_;
  std::map<NodeId, Outbox> outboxes_;
};

// The credit that a share owes to the nodes that send to it. Credit is not given for each packet: what is owed is
// always so little that the other node can go on sending.
class OwedCredit {
 public:
  // A node has sent a packet, and has this window.
  void note_window(NodeId from, std::uint64_t window_bytes) { owed_[from].held_back = Outbox::held_back(window_bytes); }
  // So many bytes of what the node has sent were taken, or dropped. Returns whether credit is to be given now.
  bool add(NodeId to, std::uint64_t bytes) {
    Owed& owed = owed_[to];
    owed.bytes += bytes;
    return owed.bytes >= owed.held_back;
  }
  // Returns how many bytes are owed to the node. From now on none are.
  std::uint64_t give(NodeId to) { return std::exchange(owed_[to].bytes, 0); }

 private:
  struct Owed {
    std::uint64_t bytes = 0, held_back = 0;  // held_back: how many bytes may be owed
  };
  std::map<NodeId, Owed> owed_;
};

// The updates of epochs whose tables are still to come.
class EarlyMail {
 public:
  struct Early {
    NodeId from;
    Update update;
  };

  // Keeps an update. Returns false when these are more bytes than nodes send that keep to their windows. `nodes` is the
  // number of nodes by the newest table. Up to twice as many may send, because others join. The bound is there because
  // a node that ignores its window could otherwise fill the memory.
  bool keep(NodeId from, Update update, std::size_t nodes);
  std::uint64_t bytes() const { return bytes_; }
  // Returns all that was kept, in the order in which it came, and keeps it no longer.
  std::vector<Early> take() {
    bytes_ = 0;
    return std::exchange(early_, {});
  }

 private:
  std::vector<Early> early_;
  std::uint64_t bytes_ = 0;  // as Outbox counts them
};

}  // namespace tessera

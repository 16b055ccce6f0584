// What a job tells those who watch it. Written by many threads, read by one display; no locks on the hot path.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "src/base/ids.h"
#include "src/base/mail_arcs.h"
#include "src/base/phases.h"
#include "src/base/tile_map.h"

namespace tessera {

// A span of time in which one thread worked on one tile: the report's timeline.
struct PhaseSpan {
  Phase phase;
  TileId tile;
  std::uint32_t thread;     // 0..threads-1
  double begin_s, end_s;    // since the job began
  std::uint32_t times = 1;  // so many spans of this thread and phase, the first of which was for this tile
};

struct BusyThreads {
  double until_s = 0;
  std::vector<double> threads;  // by part of the time from 0 to until_s
};

// A hundred thousand tiles work a million times: of a timeline of any length some 50,000 spans are kept. Short ones of
// a thread and a phase, with short pauses between them, become one.
class Timeline {
 public:
  void add(const PhaseSpan& span);
  const std::vector<PhaseSpan>& spans() const { return spans_; }
  // How many threads worked, on average, in each of `parts` equal parts of the time up to the last end of a span: what
  // is being worked on is told when it ends.
  BusyThreads busy(std::size_t parts) const;

 private:
  std::vector<PhaseSpan> spans_;
  double short_s_ = 0;
};

// What a node of a cluster does for a job.
struct NodeProgress {
  std::string name;
  std::uint32_t tiles = 0, tiles_triangulated = 0, tiles_stored = 0;
  std::uint64_t memory_bytes = 0;
  bool lost = false;
  friend bool operator==(const NodeProgress&, const NodeProgress&) = default;
};

struct Progress {
  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  std::atomic<Phase> phase{Phase{}};           // the first
  std::atomic<std::uint64_t> points_total{0};  // 0 while unknown
  std::atomic<std::uint64_t> points_routed{0};
  std::atomic<std::uint64_t> points_triangulated{0};
  std::atomic<std::uint32_t> tiles_total{0};
  std::atomic<std::uint32_t> tiles_triangulated{0};
  std::atomic<std::uint32_t> tiles_stored{0};
  std::atomic<std::uint32_t> tiles_asleep{0};
  std::atomic<std::uint64_t> updates_sent{0};  // updates_sent - updates_processed are in flight
  std::atomic<std::uint64_t> updates_processed{0};
  std::atomic<std::uint64_t> points_sent{0};
  std::atomic<std::uint32_t> nodes_lost{0};
  std::atomic<std::uint64_t> memory_bytes{0};  // what the nodes believe their tiles hold
  // Sent from node to node, and how often something had to wait for the receiver.
  std::atomic<std::uint64_t> bytes_between{0}, credit_waits{0};

  // For the job's log. Called from any thread.
  std::function<void(const std::string&)> log = [](const std::string&) {};

  TileMap map;
  RecentMail mail;

  void add_span(const PhaseSpan& span) {
    if (const auto reached = row_of(span.phase).reached) map.reached(span.tile, *reached);
    const std::lock_guard lock(mutex_);
    timeline_.add(span);
  }
  // Of a cluster, those that have had a part in the job, in order of coming.
  void set_nodes(std::vector<NodeProgress> nodes) {
    const std::lock_guard lock(mutex_);
    nodes_.swap(nodes);
  }
  std::vector<NodeProgress> nodes() const {
    const std::lock_guard lock(mutex_);
    return nodes_;
  }
  std::vector<PhaseSpan> spans() const {
    const std::lock_guard lock(mutex_);
    return timeline_.spans();
  }
  BusyThreads busy(std::size_t parts) const {
    const std::lock_guard lock(mutex_);
    return timeline_.busy(parts);
  }

 private:
  mutable std::mutex mutex_;
  Timeline timeline_;
  std::vector<NodeProgress> nodes_;
};

}  // namespace tessera

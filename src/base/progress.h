// What a job tells people who watch it. Many threads write it, and one display reads it. The hot path takes no locks.
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

// A span of time in which one thread worked on one tile, for the timeline of the report.
struct PhaseSpan {
  Phase phase;
  TileId tile;
  std::uint32_t thread;     // 0..threads-1
  double begin_s, end_s;    // in seconds since the job began
  std::uint32_t times = 1;  // the number of spans merged into this one; `tile` belongs to the first
};

// How many threads worked over time.
struct BusyThreads {
  double until_s = 0;
  std::vector<double> threads;  // for each part of the time from 0 to until_s: the average number of threads
};

// Keeps a job's spans. A hundred thousand tiles make a million spans, so at most 50,000 are kept for a job of any
// length. Short spans of one thread and phase that follow each other closely are merged. Not thread-safe.
class Timeline {
 public:
  void add(const PhaseSpan& span);
  const std::vector<PhaseSpan>& spans() const { return spans_; }
  // Returns the average number of working threads in each of `parts` equal parts of the time up to the end of the last
  // span. A span is added when it ends, so work that still goes on is not counted.
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

// The progress of a job. Thread-safe.
struct Progress {
  const std::chrono::steady_clock::time_point started = std::chrono::steady_clock::now();
  std::atomic<Phase> phase{Phase{}};           // the first phase
  std::atomic<std::uint64_t> points_total{0};  // 0 while unknown
  std::atomic<std::uint64_t> points_routed{0};
  std::atomic<std::uint64_t> points_triangulated{0};
  std::atomic<std::uint32_t> tiles_total{0};
  std::atomic<std::uint32_t> tiles_triangulated{0};
  std::atomic<std::uint32_t> tiles_stored{0};
  std::atomic<std::uint32_t> tiles_asleep{0};
  std::atomic<std::uint64_t> updates_sent{0};  // updates_sent - updates_processed updates are in flight
  std::atomic<std::uint64_t> updates_processed{0};
  std::atomic<std::uint64_t> points_sent{0};
  std::atomic<std::uint32_t> nodes_lost{0};
  std::atomic<std::uint64_t> memory_bytes{0};  // the memory of all tiles, as the nodes estimate it
  // The bytes sent between nodes, and how often data had to wait for the receiver.
  std::atomic<std::uint64_t> bytes_between{0}, credit_waits{0};

  // Writes a line to the job's log. May be called from any thread.
  std::function<void(const std::string&)> log = [](const std::string&) {};

  TileMap map;
  RecentMail mail;

  void add_span(const PhaseSpan& span) {
    if (const auto reached = row_of(span.phase).reached) map.note_reached(span.tile, *reached);
    const std::lock_guard lock(mutex_);
    timeline_.add(span);
  }
  // The nodes of a cluster that have or had a share of the job, in the order in which they joined it.
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

// What the progress display says, as a function of snapshots of the job: no clocks, no terminal.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "src/base/progress.h"

namespace tessera {

struct ProgressSnapshot {
  double elapsed_s = 0;
  Phase phase = {};  // the first phase
  std::uint64_t points_total = 0, points_routed = 0, points_triangulated = 0;
  std::uint32_t tiles_total = 0, tiles_triangulated = 0, tiles_stored = 0, tiles_asleep = 0;
  std::uint64_t updates_sent = 0, updates_processed = 0, points_sent = 0;
  std::uint64_t memory_bytes = 0, bytes_between = 0, credit_waits = 0;
  std::vector<NodeProgress> nodes = {};
};

ProgressSnapshot look(const Progress& progress, double elapsed_s);

// Returns how much of the whole job is done, 0..1.
double fraction_done(const ProgressSnapshot& now);

// Returns points a second in the current phase, between two snapshots; 0 when the phase moves no points.
double points_per_second(const ProgressSnapshot& before, const ProgressSnapshot& now);

// Returns two lines, three in a cluster, at most `columns` wide and without line ends: a bar, and the figures.
std::vector<std::string> progress_panel(const ProgressSnapshot& before, const ProgressSnapshot& now, int columns);
// Returns one line for logs: "12.3 s  triangulating  40 %  tiles 3/8 ...".
std::string progress_text(const ProgressSnapshot& before, const ProgressSnapshot& now);
// Returns one JSON object: {"event":"progress","phase":...}.
std::string progress_json(const ProgressSnapshot& before, const ProgressSnapshot& now);

}  // namespace tessera

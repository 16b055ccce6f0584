// Where a scanner was, from the pulses of which it has heard several returns: where their lines come together.
//
// After M. Roussel's track_sensor in lidR (2020) and D. Gatziolis and R. J. McGaughey, Reconstructing aircraft
// trajectories from multi-return airborne laser-scanning data, Remote Sensing 2019; robust, and with reasons to refuse.
// docs/track.md has the constants and their reasons.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "src/track/pulses.h"
#include "src/track/track.h"

namespace tessera {

// What was found on a flight line.
struct TrackLine {
  std::uint32_t line = 0;
  std::size_t pulses = 0;             // long enough
  std::size_t windows = 0, kept = 0;  // of half a second with enough pulses; of these, that agree
  double median_degrees = 0;          // between pulses and the way to where the scanner is said to be, in these
  double most_degrees = 0;            // likewise: 99 % of the pulses are off by less
  double height = 0;                  // above first returns, the median
  std::string refused;                // why the line has no track; empty: it has
};

struct EstimatedTrack {
  Track track;  // of the lines that are not refused
  std::vector<TrackLine> lines;
};

// A function of the set of pulses alone. `pulses`: by line and time.
EstimatedTrack estimate_track(const std::vector<Pulse>& pulses);

}  // namespace tessera

// Where a scanner was: where the lines of those pulses come together of which it has heard several returns; else where
// the scan angles of its points say.
//
// Pulses after M. Roussel's track_sensor in lidR (2020) and D. Gatziolis and R. J. McGaughey, Reconstructing aircraft
// trajectories from multi-return airborne laser-scanning data, Remote Sensing 2019; robust, and with reasons to refuse.
// docs/track.md has the constants and their reasons.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "src/surface/track/pulses.h"
#include "src/surface/track/scan_angles.h"
#include "src/surface/track/track.h"

namespace tessera {

// What was found on a flight line.
struct TrackLine {
  std::uint32_t line = 0;
  enum class From : std::uint8_t { pulses, angles };
  From from = From::pulses;
  std::size_t observations = 0;       // pulses that are long enough, or points with scan angles
  std::size_t windows = 0, kept = 0;  // of half a second with enough of them; of these, that agree
  double median_degrees = 0;          // between their directions and that to where the scanner is said to be, in these
  double most_degrees = 0;            // likewise: 99 % of them are off by less
  double height = 0;                  // above the points, the median
  std::string refused;                // why the line has no track; empty: it has
};

struct EstimatedTrack {
  Track track;  // of the lines that are not refused
  std::vector<TrackLine> lines;
};

// A function of these sets alone. `pulses`, `angles`: by line and time. Of a line whose pulses tell nothing, angles do.
EstimatedTrack estimate_track(std::span<const Pulse> pulses, std::span<const AngledPoint> angles);

}  // namespace tessera

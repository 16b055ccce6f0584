// Estimates where a scanner was: where the lines of pulses with several returns meet, or else from the scan angles of
// its points.
//
// Pulses after M. Roussel's track_sensor in lidR (2020) and D. Gatziolis and R. J. McGaughey, Reconstructing aircraft
// trajectories from multi-return airborne laser-scanning data, Remote Sensing 2019; here the fit is robust, and gives
// reasons when it refuses. docs/track.md has the constants and their reasons.
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
  std::size_t windows = 0, kept = 0;  // windows of half a second with enough observations; windows of these that agree
  // median angle between observed directions and the direction to the estimated scanner, in the kept windows
  double median_degrees = 0;
  double most_degrees = 0;  // likewise: 99 % of the observations are off by less
  double height = 0;        // of the scanner above the points, the median
  std::string refused;      // why the line has no track; empty: it has one
};

struct EstimatedTrack {
  Track track;  // of the lines that are not refused
  std::vector<TrackLine> lines;
};

// Estimates the track; the result depends on these two sets alone. `pulses`, `angles`: ordered by line and time. Angles
// serve lines whose pulses tell nothing.
EstimatedTrack estimate_track(std::span<const Pulse> pulses, std::span<const AngledPoint> angles);

}  // namespace tessera

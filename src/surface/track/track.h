// Where a scanner was at each time (GPS time of its pulses), on each of its flight lines.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

class Track {
 public:
  struct TrackPoint {
    double time = 0;
    Point at;
  };

  // Reads a CSV file. Its header names time, x, y, z and perhaps line, in any order; further columns are ignored. Times
  // must ascend within a line. Errors: bad_input, which names file, line and reason; io.
  static Result<Track> read(const std::filesystem::path& file);
  // The same from text. `name`: for errors.
  static Result<Track> parse(std::string_view text, const std::filesystem::path& name);
  // Writes the same format, with enough digits to read the same numbers back.
  std::string to_csv() const;

  // Adds a flight line. REQUIRES: values are finite, times ascend, and the line has no points yet.
  void add(std::uint32_t line, std::vector<TrackPoint> points);

  // Returns the scanner's position at a time. Between points that are at most `gap_max` apart the path is straight; it
  // continues for `beyond` before the first point and behind the last. Nothing elsewhere. Where the track does not tell
  // lines apart, `line` is ignored.
  std::optional<Point> at(std::uint32_t line, double time) const;
  static constexpr double gap_max = 10, beyond = 1;  // seconds

  bool empty() const { return lines_.empty(); }
  bool tells_lines() const { return tells_lines_; }
  const std::map<std::uint32_t, std::vector<TrackPoint>>& lines() const { return lines_; }

 private:
  std::map<std::uint32_t, std::vector<TrackPoint>> lines_;
  bool tells_lines_ = true;
};

}  // namespace tessera

// Where a scanner was, by the time of its pulses (GPS time), on each of its flight lines.
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
  struct Place {
    double time = 0;
    Point at;
  };

  // A CSV file: a header with time, x, y, z and perhaps line, in any order; further columns are not looked at. Times
  // ascend within a line. Errors: bad_input, which names file, line and reason; io.
  static Result<Track> read(const std::filesystem::path& file);
  // The same from text; `name`: for errors.
  static Result<Track> parse(std::string_view text, const std::filesystem::path& name);
  // The same, the digits that read back as the same numbers.
  std::string to_csv() const;

  // REQUIRES: finite, times ascend, and the line has none yet.
  void add(std::uint32_t line, std::vector<Place> places);

  // Between places that are at most `gap_max` apart on a straight way, and as far on as `beyond` before the first and
  // behind the last. Nothing elsewhere. Where lines are not told apart, `line` does not count.
  std::optional<Point> at(std::uint32_t line, double time) const;
  static constexpr double gap_max = 10, beyond = 1;  // seconds

  bool empty() const { return lines_.empty(); }
  bool tells_lines() const { return tells_lines_; }
  const std::map<std::uint32_t, std::vector<Place>>& lines() const { return lines_; }

 private:
  std::map<std::uint32_t, std::vector<Place>> lines_;
  bool tells_lines_ = true;
};

}  // namespace tessera

#include "src/surface/track/track.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "src/base/files/whole_file.h"
#include "src/input/bytes/number.h"

namespace tessera {

namespace {

constexpr std::array<std::string_view, 5> names{"time", "x", "y", "z", "line"};

std::vector<std::string_view> cells_of(std::string_view row) {
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= row.size();) {
    const std::size_t end = std::min(row.find(',', at), row.size());
    std::string_view cell = row.substr(at, end - at);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t' || cell.back() == '\r')) cell.remove_suffix(1);
    cells.push_back(cell);
    at = end + 1;
  }
  return cells;
}

// The rows of a file. bad() makes an error about the current row.
class Rows {
 public:
  Rows(std::filesystem::path file, std::string_view text) : file_(std::move(file)), text_(text) {}
  // Returns the next row that is not blank; nothing at the end.
  std::optional<std::string_view> next() {
    while (at_ < text_.size()) {
      const std::size_t end = std::min(text_.find('\n', at_), text_.size());
      const std::string_view row = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++number_;
      if (row.find_first_not_of(" \t\r") != std::string_view::npos) return row;
    }
    return std::nullopt;
  }
  Error bad(const std::string& reason) const {
    return error(Errc::bad_input, file_.string() + ", line " + std::to_string(number_) + ": " + reason);
  }

 private:
  std::filesystem::path file_;
  std::string_view text_;
  std::size_t at_ = 0, number_ = 0;
};

// Returns which column has which name. Only the column `line` may be missing.
Result<std::array<std::optional<std::size_t>, names.size()>> columns_of(const Rows& rows, std::string_view header) {
  std::array<std::optional<std::size_t>, names.size()> columns;
  const auto cells = cells_of(header);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto found = std::find(cells.begin(), cells.end(), names[i]);
    if (found != cells.end()) columns[i] = static_cast<std::size_t>(found - cells.begin());
    if (!columns[i] && names[i] != "line")
      return rows.bad("the header names no column '" + std::string(names[i]) +
                      "'; the header must be time,x,y,z or time,x,y,z,line");
  }
  return columns;
}

}  // namespace

Result<Track> Track::read(const std::filesystem::path& file) {
  BOOST_OUTCOME_TRY(bytes, read_whole(file));
  return parse(as_text(bytes), file);
}

Result<Track> Track::parse(std::string_view text, const std::filesystem::path& file) {
  Rows rows(file, text);
  const auto header = rows.next();
  if (!header) return error(Errc::bad_input, file.string() + ": is empty; a track begins with time,x,y,z");
  BOOST_OUTCOME_TRY(columns, columns_of(rows, *header));
  Track track;
  track.tells_lines_ = columns.back().has_value();
  while (const auto row = rows.next()) {
    const auto cells = cells_of(*row);
    std::array<double, names.size()> values{};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!columns[i]) continue;
      if (*columns[i] >= cells.size()) return rows.bad("has no column '" + std::string(names[i]) + "'");
      const auto value = parse_number(cells[*columns[i]]);
      if (!value || !std::isfinite(*value)) return rows.bad(std::string(names[i]) + " is not a finite number");
      values[i] = *value;
    }
    const double line = values.back();
    if (line < 0 || line > std::numeric_limits<std::uint32_t>::max() || line != std::floor(line))
      return rows.bad("line is not a whole number of 32 bits");
    auto& points = track.lines_[static_cast<std::uint32_t>(line)];
    if (!points.empty() && points.back().time >= values[0])
      return rows.bad("its time is not after that of the line before");
    points.push_back({values[0], without_negative_zero({values[1], values[2], values[3]})});
  }
  if (track.empty()) return error(Errc::bad_input, file.string() + ": has no positions, only a header");
  return track;
}

std::string Track::to_csv() const {
  std::string text = tells_lines_ ? "time,x,y,z,line\n" : "time,x,y,z\n";
  const auto put = [&](double value, char after) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text.append(digits.data(), end);
    text += after;
  };
  for (const auto& [line, points] : lines_) {
    for (const TrackPoint& point : points) {
      put(point.time, ',');
      put(point.at.x, ',');
      put(point.at.y, ',');
      put(point.at.z, tells_lines_ ? ',' : '\n');
      if (tells_lines_) text += std::to_string(line) + '\n';
    }
  }
  return text;
}

void Track::add(std::uint32_t line, std::vector<TrackPoint> points) { lines_[line] = std::move(points); }

std::optional<Point> Track::at(std::uint32_t line, double time) const {
  const auto found = tells_lines_ ? lines_.find(line) : lines_.begin();
  if (found == lines_.end() || !std::isfinite(time)) return std::nullopt;
  const auto& points = found->second;
  const auto after = std::lower_bound(points.begin(), points.end(), time,
                                      [](const TrackPoint& point, double wanted) { return point.time < wanted; });
  const auto mixed = [&](const TrackPoint& a, const TrackPoint& b) -> std::optional<Point> {
    const double part = (time - a.time) / (b.time - a.time);
    const Point at{a.at.x + (b.at.x - a.at.x) * part, a.at.y + (b.at.y - a.at.y) * part,
                   a.at.z + (b.at.z - a.at.z) * part};
    return is_finite(at) ? std::optional(at) : std::nullopt;
  };
  const bool first = after == points.begin(), last = after == points.end();
  if (!first && !last && after->time - (after - 1)->time <= gap_max) return mixed(*(after - 1), *after);
  // At an end, or at the edge of a gap: the path continues in its direction.
  if (!last && after->time - time <= beyond) {
    const bool way = after + 1 != points.end() && (after + 1)->time - after->time <= gap_max;
    return way ? mixed(*after, *(after + 1)) : after->at;
  }
  if (!first && time - (after - 1)->time <= beyond) {
    const auto before = after - 1;
    const bool way = before != points.begin() && before->time - (before - 1)->time <= gap_max;
    return way ? mixed(*(before - 1), *before) : before->at;
  }
  return std::nullopt;
}

}  // namespace tessera

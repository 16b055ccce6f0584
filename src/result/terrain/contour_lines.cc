#include "src/result/terrain/contour_lines.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <tuple>
#include <utility>

#include "src/base/option.h"
#include "src/base/stoppable_sort.h"

namespace tessera::terrain {

Result<ContourLines> ContourLines::create(const std::filesystem::path& folder, const Memory& memory,
                                          std::stop_token stop) {
  BOOST_OUTCOME_TRY(file, nameless_file(folder));
  return ContourLines(std::move(file), folder, memory, std::move(stop));
}

Result<ContourLines::Line> ContourLines::write(std::int64_t level, std::span<const LinePoint> points) {
  const Line line{.level = level, .a = points[0].a, .b = points[0].b, .first = written_, .count = points.size()};
  BOOST_OUTCOME_TRYV(write_at(file_.get(), std::as_bytes(points), written_ * sizeof(LinePoint), folder_));
  written_ += points.size();
  return line;
}

Status ContourLines::read(const Line& line, std::vector<LinePoint>& points) const {
  const std::size_t before = points.size();
  points.resize(before + line.count);
  const auto bytes = std::as_writable_bytes(std::span(points).subspan(before));
  BOOST_OUTCOME_TRY(read, read_up_to(file_.get(), bytes, line.first * sizeof(LinePoint), folder_));
  if (read != bytes.size()) return io_error(folder_, "cannot read back a scratch file", EIO);
  return success();
}

namespace {

constexpr std::uint32_t chains_a_look = 1024;  // each chain is read from disk

// Rotates a closed line so that it begins at its least edge.
void turn(std::vector<LinePoint>& points) {
  points.pop_back();
  const auto least = std::min_element(points.begin(), points.end(),
                                      [](const LinePoint& a, const LinePoint& b) { return a.edge() < b.edge(); });
  std::rotate(points.begin(), least, points.end());
  points.push_back(points.front());
}

}  // namespace

Status ContourLines::add(std::int64_t level, std::span<const LinePoint> points) {
  const bool closed = points.front().edge() == points.back().edge();
  std::vector<LinePoint> turned;
  if (closed) {
    turned.assign(points.begin(), points.end());
    turn(turned);
    points = turned;
  }
  const std::lock_guard lock(*mutex_);
  BOOST_OUTCOME_TRY(line, write(level, points));
  if (closed) return sorted_.push(line);
  if (chains_.size() >= chains_max_)
    return error(Errc::memory, "the memory is too small: more than " + std::to_string(chains_max_) +
                                   " lines end at borders of tiles; give a larger " + option("interval") + " or more " +
                                   option("memory"));
  chains_.push_back({line, points.back().a, points.back().b});
  return success();
}

// A chain that begins at the edge where another chain ends continues it: of the two pieces at an edge, one ends and one
// begins there.
Status ContourLines::link_chains() {
  sort_unless_stopped(chains_.begin(), chains_.end(), stop_,
                      [](const Chain& a, const Chain& b) { return a.line < b.line; });
  constexpr std::size_t none = ~std::size_t{0};
  std::vector<std::size_t> next(chains_.size(), none);
  std::vector<bool> goes_on(chains_.size()), used(chains_.size());
  StopCheck check(stop_, chains_a_look);
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    check.step();
    const Chain& chain = chains_[i];
    const Line wanted{.level = chain.line.level, .a = chain.end_a, .b = chain.end_b};
    const auto found = std::lower_bound(chains_.begin(), chains_.end(), wanted,
                                        [](const Chain& at, const Line& line) { return at.line < line; });
    if (found == chains_.end() || wanted < found->line) continue;
    next[i] = static_cast<std::size_t>(found - chains_.begin());
    goes_on[next[i]] = true;
  }
  std::vector<LinePoint> points;
  const auto follow = [&](std::size_t first) -> Status {
    points.clear();
    for (std::size_t i = first; i != none && !used[i]; i = next[i]) {
      check.step();
      used[i] = true;
      if (!points.empty()) points.pop_back();  // the next chain begins there
      BOOST_OUTCOME_TRYV(read(chains_[i].line, points));
    }
    if (points.front().edge() == points.back().edge()) turn(points);
    BOOST_OUTCOME_TRY(line, write(chains_[first].line.level, points));
    return sorted_.push(line);
  };
  for (const bool closed : {false, true}) {
    for (std::size_t i = 0; i < chains_.size(); ++i) {
      if (used[i] || (!closed && goes_on[i])) continue;
      BOOST_OUTCOME_TRYV(follow(i));
    }
  }
  std::vector<Chain>().swap(chains_);
  return success();
}

Status ContourLines::for_each(const std::function<Status(std::int64_t, std::span<const Point>)>& visit) {
  try {
    BOOST_OUTCOME_TRYV(link_chains());
  } catch (const Stopped&) {
    return error(Errc::interrupted, "interrupted while linking lines");
  }
  std::vector<LinePoint> points;
  std::vector<Point> places;
  return sorted_.for_each([&](const Line& line) -> Status {
    points.clear();
    places.clear();
    BOOST_OUTCOME_TRYV(read(line, points));
    const bool closed = points.front().edge() == points.back().edge();
    for (const LinePoint& p : points) {
      const Point at{p.x, p.y, 0};
      if (places.empty() || places.back() != at) places.push_back(at);
    }
    if (places.size() < (closed ? 4 : 2)) return success();
    return visit(line.level, places);
  });
}

}  // namespace tessera::terrain

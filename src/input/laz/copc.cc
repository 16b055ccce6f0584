#include "src/input/laz/copc.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "src/base/option.h"
#include "src/input/bytes/far_source.h"
#include "src/input/bytes/fields.h"
#include "src/input/file_part.h"

namespace tessera::laz {
namespace {

constexpr std::size_t info_bytes = 160, entry_bytes = 32;
// At level 30 a cube of the earth's size is a centimetre wide. x, y and z of a key must stay below 2^31.
constexpr std::int32_t level_max = 30;

struct Page {
  std::uint64_t offset, bytes;
};

// Eight million nodes, more than the largest files have. The root page has no other bound but the file's size, which a
// server may make up.
constexpr std::uint64_t page_bytes_max = std::uint64_t{256} << 20;

struct Octree {
  std::array<double, 3> lo{};  // the lower corner of the root cube
  double side = 0, slack = 0;  // slack: how far rounding may put a point outside its cube
  std::int32_t finest = level_max;

  Bounds cube(std::int32_t level, const std::array<std::int32_t, 3>& key) const {
    const double width = std::ldexp(side, -level);
    Bounds bounds;
    for (int axis = 0; axis < 3; ++axis) {
      const double begin = lo[static_cast<std::size_t>(axis)] + key[static_cast<std::size_t>(axis)] * width;
      bounds.lo[axis] = begin - slack;
      bounds.hi[axis] = begin + width + slack;
    }
    return bounds;
  }
};

// Returns the part of `cube` within the header's box, which rounding may have made too small by `slack`. If there is no
// such part, one of the two is wrong, and the whole cube is returned.
Bounds clipped(const Bounds& cube, const Bounds& header, double slack) {
  if (header.empty()) return cube;
  Bounds both;
  for (int axis = 0; axis < 3; ++axis) {
    both.lo[axis] = std::max(cube.lo[axis], header.lo[axis] - slack);
    both.hi[axis] = std::min(cube.hi[axis], header.hi[axis] + slack);
    if (both.lo[axis] > both.hi[axis]) return cube;
  }
  return both;
}

// What the info record says. `bad` makes the error of a sentence.
Result<Octree> octree_of(const LasHeader& header, const ReadHints& hints,
                         const std::function<Error(const std::string&)>& bad) {
  const auto* info = header.copc.data();
  const double half = load<double>(info + 24), spacing = load<double>(info + 32);
  Octree octree{.lo = {}, .side = 2 * half, .slack = 1e-9 * half};
  if (!std::isfinite(octree.side) || half <= 0)
    return bad("info record: the octree is " + std::to_string(octree.side) + " wide");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double center = load<double>(info + 8 * axis);
    if (!std::isfinite(center)) return bad("info record: the centre of the octree is not finite");
    octree.lo[axis] = center - half;
    octree.slack = std::max(octree.slack, std::abs(header.scale[axis]) + 1e-15 * std::abs(center));
  }
  if (hints.resolution > 0) {
    if (!std::isfinite(spacing) || spacing <= 0)
      return bad("info record: the spacing is " + std::to_string(spacing) + ", so " + option("resolution") +
                 " cannot be met");
    octree.finest = 0;
    while (octree.finest < level_max && std::ldexp(spacing, -octree.finest) > hints.resolution) ++octree.finest;
  }
  return octree;
}

// Fetches pages of a far file together, unless what is said of them is impossible or too much.
Status bring_pages(const ByteSource& source, std::vector<ByteRange> pages) {
  std::uint64_t bytes = 0;
  for (const auto& page : pages) {
    if (page.end < page.begin || page.end > source.size()) return success();
    bytes += page.end - page.begin;
    if (bytes > page_bytes_max) return success();
  }
  return bring_near(source, pages);
}

}  // namespace

Result<std::vector<CopcNode>> read_copc_nodes(const ByteSource& source, const LasHeader& header,
                                              const ReadHints& hints) {
  const auto bad = [&](const std::string& what) {
    return error(Errc::bad_input, source.path().string() + ", COPC " + what);
  };
  if (header.copc.size() < info_bytes)
    return bad("info record: has " + std::to_string(header.copc.size()) + " bytes, not " + std::to_string(info_bytes));
  const auto* info = header.copc.data();
  BOOST_OUTCOME_TRY(octree, octree_of(header, hints, bad));

  const Box everything;
  const Box& box = hints.crop ? *hints.crop : everything;
  std::vector<CopcNode> nodes;
  std::vector<Page> pages{{load<std::uint64_t>(info + 40), load<std::uint64_t>(info + 48)}};
  std::uint64_t bytes_read = 0;
  std::vector<std::byte> raw;
  while (!pages.empty()) {
    const Page page = pages.back();
    pages.pop_back();
    const auto bad_page = [&](const std::string& what) {
      return bad("hierarchy page at byte " + std::to_string(page.offset) + ": " + what);
    };
    if (page.offset > source.size() || page.bytes > source.size() - page.offset)
      return bad_page("its " + std::to_string(page.bytes) + " bytes reach beyond the file");
    if (page.bytes > page_bytes_max)
      return bad_page("it has " + std::to_string(page.bytes) + " bytes; at most " + std::to_string(page_bytes_max) +
                      " are read");
    // Pages do not overlap. So together they are at most as long as the file, unless they lead in a circle.
    if ((bytes_read += page.bytes) > source.size())
      return bad_page("the pages up to this one are together longer than the file, so they form a circle or overlap");
    raw.resize(page.bytes);
    std::vector<ByteRange> below;  // the pages to which this one leads
    BOOST_OUTCOME_TRYV(source.read(page.offset, raw));
    for (std::size_t at = 0; at + entry_bytes <= raw.size(); at += entry_bytes) {
      const auto* entry = raw.data() + at;
      const auto level = load<std::int32_t>(entry);
      const std::array key{load<std::int32_t>(entry + 4), load<std::int32_t>(entry + 8),
                           load<std::int32_t>(entry + 12)};
      const auto offset = load<std::uint64_t>(entry + 16);
      const auto bytes = load<std::int32_t>(entry + 24), points = load<std::int32_t>(entry + 28);
      if (level < 0 || level > level_max || points < -1 || bytes < 0)
        return bad_page("entry " + std::to_string(at / entry_bytes) + " is impossible: level " + std::to_string(level) +
                        " with " + std::to_string(points) + " points in " + std::to_string(bytes) + " bytes");
      const Bounds cube = octree.cube(level, key);
      if (level > octree.finest || points == 0 || !meets(cube, box)) continue;
      if (points == -1) {
        if (bytes == 0) return bad_page("leads to an empty page");
        pages.push_back({offset, static_cast<std::uint64_t>(bytes)});
        below.push_back({offset, offset + pages.back().bytes});
      } else {
        nodes.push_back({offset, static_cast<std::uint64_t>(bytes), static_cast<std::uint64_t>(points),
                         clipped(cube, header.bounds, octree.slack)});
      }
    }
    BOOST_OUTCOME_TRYV(bring_pages(source, std::move(below)));
  }
  return nodes;
}

Result<std::vector<Chunk>> chunks_of_nodes(const std::string& path, const std::vector<Chunk>& chunks,
                                           std::vector<CopcNode> nodes) {
  std::sort(nodes.begin(), nodes.end(), [](const auto& a, const auto& b) { return a.offset < b.offset; });
  std::vector<Chunk> chosen;
  auto chunk = chunks.begin();
  for (const auto& node : nodes) {
    while (chunk != chunks.end() && (chunk->begin < node.offset || chunk->points == 0)) ++chunk;
    if (chunk == chunks.end() || chunk->begin != node.offset || chunk->end - chunk->begin != node.bytes ||
        chunk->points != node.points)
      return error(Errc::bad_input, path + ", COPC hierarchy: the node of " + std::to_string(node.points) +
                                        " points at byte " + std::to_string(node.offset) +
                                        " is not in the chunk table, or is twice in the hierarchy");
    chosen.push_back(*chunk++);
  }
  return chosen;
}

}  // namespace tessera::laz

#include "src/input/ept/ept_nodes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/printable.h"
#include "src/input/ept/ept_files.h"
#include "src/input/ept/ept_names.h"

namespace tessera::ept {
namespace {

// As for COPC: numbers of cubes stay below 2^31.
constexpr std::int32_t level_max = 30;
// Some 1.5 GB of memory. Clouds of 300 billion points have as many.
constexpr std::size_t nodes_max = std::size_t{1} << 24;

std::optional<Key> key_of(std::string_view text) {
  std::array<std::int32_t, 4> numbers{};
  const char *at = text.data(), *end = at + text.size();
  for (std::size_t i = 0; i < 4; ++i) {
    if (i > 0 && (at == end || *at++ != '-')) return {};
    const auto [next, wrong] = std::from_chars(at, end, numbers[i]);
    if (wrong != std::errc() || *at == '-') return {};
    at = next;
  }
  if (at != end || numbers[0] > level_max) return {};
  const Key key{numbers[0], {numbers[1], numbers[2], numbers[3]}};
  for (const std::int32_t number : key.at)
    if ((static_cast<std::int64_t>(number) >> key.level) != 0) return {};
  return key;
}

// Reads the files of a hierarchy. Each leads to others.
class HierarchyReader {
 public:
  HierarchyReader(const ByteSource& ept, const Info& info) : ept_(ept), info_(info) {}

  Status read_all() {
    std::vector<Key> pages{Key{}};
    while (!pages.empty()) {
      std::vector<Key> below;
      for (std::size_t begin = 0; begin < pages.size(); begin += files_at_once) {
        const auto next = std::span(pages).subspan(begin, std::min(files_at_once, pages.size() - begin));
        BOOST_OUTCOME_TRYV(read_pages(next, below));
      }
      pages = std::move(below);
    }
    return success();
  }

  std::map<Key, std::uint64_t> take() { return std::move(points_); }

 private:
  // Adds the pages to which these lead to `below`.
  Status read_pages(std::span<const Key> pages, std::vector<Key>& below) {
    const Files files;
    std::vector<std::filesystem::path> paths;
    for (const Key& page : pages) paths.push_back(hierarchy_file(info_, page));
    BOOST_OUTCOME_TRYV(files.bring(ept_, paths));
    for (const Key& page : pages) {
      BOOST_OUTCOME_TRYV(read_page(files, page, below));
    }
    return success();
  }

  Status read_page(const Files& files, const Key& page, std::vector<Key>& pages) {
    const auto path = hierarchy_file(info_, page);
    BOOST_OUTCOME_TRY(source, files.open(ept_, path));
    BOOST_OUTCOME_TRY(text, read_text(*source));
    const nlohmann::json all = parse_json(text);
    const auto bad = [&](const std::string& what) { return error(Errc::bad_input, path.string() + ": " + what); };
    if (!all.is_object()) return bad("is not a JSON object with the nodes of a hierarchy");
    for (const auto& [name, value] : all.items()) {
      const auto key = key_of(name);
      if (!key) return bad(in_quotes(name) + " is no node of an octree");
      if (!value.is_number_integer()) return bad(in_quotes(name) + " has no number of points");
      const auto points = value.get<std::int64_t>();
      if (points == -1) {
        // Only the file of the node itself may say how many points it has.
        if (*key == page) return bad(in_quotes(name) + " leads to this file itself");
        pages.push_back(*key);
        continue;
      }
      if (points < 0 || static_cast<std::uint64_t>(points) > info_.points)
        return bad(in_quotes(name) + " has " + std::to_string(points) + " points, and the whole cloud " +
                   std::to_string(info_.points));
      if (!points_.emplace(*key, points).second) return bad(in_quotes(name) + " is in the hierarchy twice");
      if (points_.size() > nodes_max) return bad("the hierarchy has more than 16 million nodes");
    }
    // A page that leads to pages that were read would never end.
    if (!points_.contains(page)) return bad("does not have its own node, " + page.text());
    return success();
  }

  const ByteSource& ept_;
  const Info& info_;
  std::map<Key, std::uint64_t> points_;
};

}  // namespace

std::string Key::text() const {
  std::string text = std::to_string(level);
  for (const std::int32_t number : at) text += "-" + std::to_string(number);
  return text;
}

std::filesystem::path tile_file(const Info& info, const Key& key) {
  const char* ending = info.tiles == Info::Tiles::laz ? ".laz" : info.tiles == Info::Tiles::binary ? ".bin" : ".zst";
  return info.path.parent_path() / ept_tiles_folder / (key.text() + ending);
}

std::filesystem::path hierarchy_file(const Info& info, const Key& key) {
  return info.path.parent_path() / ept_hierarchy_folder / (key.text() + ".json");
}

Result<std::vector<Node>> read_nodes(const ByteSource& ept, const Info& info) {
  HierarchyReader reader(ept, info);
  BOOST_OUTCOME_TRYV(reader.read_all());
  std::vector<Node> nodes;
  std::uint64_t first = 0;
  for (const auto& [key, points] : reader.take()) {
    if (points == 0) continue;
    nodes.push_back({key, first, points});
    first += points;
    if (first > info.points) break;  // before the sum could exceed what 64 bits hold
  }
  if (first == info.points) return nodes;
  return error(Errc::bad_input, info.path.string() + ": has " + std::to_string(info.points) +
                                    " points, and the nodes of its hierarchy have " + std::to_string(first) +
                                    (first > info.points ? " or more" : ""));
}

std::int32_t levels_for(const Info& info, double resolution) {
  std::int32_t level = 0;
  while (level < level_max && (resolution == 0 || std::ldexp(info.spacing(), -level) > resolution)) ++level;
  return level + 1;
}

Bounds bounds_of(const Info& info, const Key& key) {
  Bounds bounds;
  const double slack = info.slack();
  for (int axis = 0; axis < 3; ++axis) {
    const double width = std::ldexp(info.cube.hi[axis] - info.cube.lo[axis], -key.level);
    const double begin = info.cube.lo[axis] + key.at[static_cast<std::size_t>(axis)] * width;
    bounds.lo[axis] = begin - slack;
    bounds.hi[axis] = begin + width + slack;
  }
  if (info.conforming.empty()) return bounds;
  Bounds both;
  for (int axis = 0; axis < 3; ++axis) {
    // Some writers round the box of all points to whole units, and cut it off at that.
    both.lo[axis] = std::max(bounds.lo[axis], info.conforming.lo[axis] - 1);
    both.hi[axis] = std::min(bounds.hi[axis], info.conforming.hi[axis] + 1);
    if (both.lo[axis] > both.hi[axis]) return bounds;
  }
  return both;
}

}  // namespace tessera::ept

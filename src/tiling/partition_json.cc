// The partition in plan.json and in the manifest. JSON that is read is not trusted: a wrong tree would send points to
// tiles whose boxes do not contain them.
#include <cmath>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/periodic_box.h"
#include "src/tiling/json_read.h"
#include "src/tiling/partition.h"

namespace tessera {
namespace {

using nlohmann::json;

Error bad(const std::string& what) { return error(Errc::corrupt, "partition: " + what); }

// Checks that every row but the root hangs from exactly one earlier row, that every leaf hangs from exactly one row,
// and that every plane is inside its box. Then leaves are disjoint, not empty, and cover space.
Status check_tree(const std::vector<SplitNode>& nodes, std::uint32_t tiles) {
  std::vector<bool> row_used(nodes.size()), leaf_used(tiles);
  std::vector<Box> boxes(nodes.size());
  for (std::size_t row = 0; row < nodes.size(); ++row) {
    const SplitNode& node = nodes[row];
    const Box& box = boxes[row];
    const std::string name = "split " + std::to_string(row);
    if (row > 0 && !row_used[row]) return bad(name + " is not the child of an earlier split");
    if (!(box.lo[node.axis] < node.value && node.value < box.hi[node.axis])) return bad(name + " is outside its box");
    for (const int side : {0, 1}) {
      const std::int32_t child = node.child[side];
      if (child < 0) {
        const TileId tile = tile_at(child);
        if (leaf_used[tile.value]) return bad("tile " + to_string(tile) + " occurs twice");
        leaf_used[tile.value] = true;
        continue;
      }
      const auto next = static_cast<std::size_t>(child);
      if (next <= row || row_used[next])
        return bad(name + " has the child " + std::to_string(child) + ", so the splits are not a tree");
      row_used[next] = true;
      boxes[next] = box;
      (side == 0 ? boxes[next].hi : boxes[next].lo)[node.axis] = node.value;
    }
  }
  return success();
}

// A period that rounds shifts would make another triangulation.
Status read_period(const json& from, int dimension, Period& period) {
  if (!from.is_array() || from.size() != 3) return bad("the period is not three numbers");
  for (int axis = 0; axis < 3; ++axis) {
    double& length = period.length[static_cast<std::size_t>(axis)];
    if (!read_finite(from[static_cast<std::size_t>(axis)], length) || length < 0 || (axis >= dimension && length > 0) ||
        (length > 0 && !is_period(length)))
      return bad(std::string("the period along ") + "xyz"[axis] + " is none");
  }
  return period.any() ? success() : Status(bad("all periods are 0"));
}

}  // namespace

std::string Partition::to_json() const {
  json splits = json::array();
  for (const SplitNode& node : nodes_) {
    splits.push_back(json::array({node.axis, node.value, node.child[0], node.child[1]}));
  }
  json value{{"kind", name_of(kind_)}, {"dimension", dimension_}, {"tiles", tiles()}, {"splits", std::move(splits)}};
  if (period_.any()) value["period"] = period_.length;
  return json_text(value);
}

Result<Partition> Partition::from_json(const std::string& text) {
  const json root = parse_json(text);
  if (!root.is_object()) return bad("it is not a JSON object");
  for (const char* key : {"kind", "dimension", "tiles", "splits"}) {
    if (!root.contains(key)) return bad(std::string(key) + " is missing");
  }
  if (!root["kind"].is_string()) return bad("kind is not a string");
  const auto kind = parse_partition_kind(root["kind"].get<std::string>());
  if (!kind) return bad("its kind is not known");
  std::int64_t dimension = 0;
  std::int64_t tiles = 0;
  if (!read_integer(root["dimension"], 2, 3, dimension)) return bad("dimension is not 2 or 3");
  if (!read_integer(root["tiles"], 1, tiles_max, tiles))
    return bad("tiles is not a number from 1 to " + std::to_string(tiles_max));
  const json& splits = root["splits"];
  if (!splits.is_array()) return bad("splits is not a list");
  const std::int64_t rows = kind.value() == PartitionKind::random ? 0 : tiles - 1;
  if (splits.size() != static_cast<std::size_t>(rows)) {
    return bad(std::to_string(splits.size()) + " splits do not make " + std::to_string(tiles) + " tiles");
  }
  std::vector<SplitNode> nodes;
  nodes.reserve(splits.size());
  for (const json& split : splits) {
    std::int64_t axis = 0;
    std::int64_t below = 0;
    std::int64_t above = 0;
    if (!split.is_array() || split.size() != 4 || !read_integer(split[0], 0, dimension - 1, axis) ||
        !split[1].is_number() || !read_integer(split[2], -tiles, rows - 1, below) ||
        !read_integer(split[3], -tiles, rows - 1, above) || !std::isfinite(split[1].get<double>())) {
      return bad("split " + std::to_string(nodes.size()) + " is not [axis, coordinate, below, above]");
    }
    nodes.push_back({split[1].get<double>() + 0.0,
                     static_cast<std::int32_t>(axis),
                     {static_cast<std::int32_t>(below), static_cast<std::int32_t>(above)}});
  }
  BOOST_OUTCOME_TRYV(check_tree(nodes, static_cast<std::uint32_t>(tiles)));
  Period period;
  if (root.contains("period")) {
    BOOST_OUTCOME_TRYV(read_period(root["period"], static_cast<int>(dimension), period));
  }
  Partition partition(kind.value(), static_cast<int>(dimension), std::move(nodes), static_cast<std::uint32_t>(tiles));
  partition.set_period(period);
  return partition;
}

}  // namespace tessera

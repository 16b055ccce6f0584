#include "tests/region/copc_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>
#include <utility>

#include "src/input/laz/prediction.h"
#include "tests/input/las_file.h"
#include "tests/input/laz_encoder.h"

namespace tessera::testing_region {

using testing_io::ArithmeticEncoder;
using testing_io::IntegerEncoder;
using testing_io::LasFile;
using testing_io::push;
using testing_io::put;

namespace {

using Record = std::array<std::int32_t, 3>;
constexpr std::size_t record_bytes = 30, layers = 9;
constexpr int level_max = 20;

struct Node {
  std::int32_t level = 0;
  std::array<std::int32_t, 3> key{};
  std::vector<Record> points;
};

// The root's cube, in steps of the file.
struct Cube {
  std::array<std::int64_t, 3> lo{};
  std::int64_t side = 1;
};

Cube cube_of(const std::vector<Record>& points) {
  Record lo = points.at(0), hi = lo;
  for (const Record& p : points)
    for (std::size_t axis = 0; axis < 3; ++axis)
      lo[axis] = std::min(lo[axis], p[axis]), hi[axis] = std::max(hi[axis], p[axis]);
  Cube cube;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cube.lo[axis] = lo[axis];
    while (hi[axis] - cube.lo[axis] >= cube.side) cube.side *= 2;
  }
  return cube;
}

class Octree {
 public:
  Octree(const CopcFile& file, const Cube& cube) : file_(file), cube_(cube) {}

  void add(Node node) {
    const std::int64_t side = cube_.side >> node.level;
    const auto place = [&](const Record& p, std::size_t axis) {
      return p[axis] - cube_.lo[axis] - node.key[axis] * side;
    };
    std::unordered_set<std::uint64_t> taken;
    std::vector<Record> here;
    std::array<std::vector<Record>, 8> children;
    for (const Record& p : node.points) {
      std::uint64_t cell = 0;
      std::size_t child = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        cell = cell * 4096 + static_cast<std::uint64_t>(place(p, axis) * file_.cells / side);
        if (side > 1 && place(p, axis) >= side / 2) child |= std::size_t{1} << axis;
      }
      if (node.level == level_max || side == 1 || taken.insert(cell).second) {
        here.push_back(p);
      } else {
        children[child].push_back(p);
      }
    }
    std::vector<Node> below;
    for (std::size_t child = 0; child < 8; ++child) {
      auto& points = children[child];
      if (points.size() <= file_.few) {
        here.insert(here.end(), points.begin(), points.end());
        continue;
      }
      Node next{.level = node.level + 1, .key = {}, .points = std::move(points)};
      for (std::size_t axis = 0; axis < 3; ++axis)
        next.key[axis] = 2 * node.key[axis] + static_cast<std::int32_t>(child >> axis & 1);
      below.push_back(std::move(next));
    }
    node.points = std::move(here);
    nodes.push_back(std::move(node));
    for (Node& next : below) add(std::move(next));
  }

  std::vector<Node> nodes;

 private:
  const CopcFile& file_;
  Cube cube_;
};

// A chunk: the first record as it is, then the layer of x and y, that of z, and all others empty.
Bytes chunk_of(const std::vector<Record>& points) {
  ArithmeticEncoder xy, z;
  laz::SymbolModel<128> changes;
  IntegerEncoder<32, 2> x_differences;
  IntegerEncoder<32, 22> y_differences;
  IntegerEncoder<32, 20> heights;
  laz::RunningMedian dx, dy;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Record &last = points[i - 1], &p = points[i];
    xy.symbol(changes, 0);
    x_differences.next(xy, dx.value(), p[0] - last[0], 1);
    dx.add(p[0] - last[0]);
    const std::uint32_t x_length = x_differences.length;
    y_differences.next(xy, dy.value(), p[1] - last[1], laz::length_context(x_length, 20, true));
    dy.add(p[1] - last[1]);
    heights.next(z, last[2], p[2], laz::length_context((x_length + y_differences.length) / 2, 18, true));
  }
  const Bytes first_layer = xy.finish(), second_layer = z.finish();
  Bytes chunk(record_bytes);
  for (std::size_t axis = 0; axis < 3; ++axis) put(chunk, 4 * axis, points[0][axis]);
  put<std::uint8_t>(chunk, 14, 0x11);  // the only return
  put<std::uint8_t>(chunk, 16, 2);     // ground
  push(chunk, static_cast<std::uint32_t>(points.size()));
  push(chunk, static_cast<std::uint32_t>(first_layer.size()));
  push(chunk, static_cast<std::uint32_t>(second_layer.size()));
  for (std::size_t layer = 2; layer < layers; ++layer) push(chunk, std::uint32_t{0});
  chunk.insert(chunk.end(), first_layer.begin(), first_layer.end());
  chunk.insert(chunk.end(), second_layer.begin(), second_layer.end());
  return chunk;
}

Bytes laszip_record() {
  Bytes record(34);
  put<std::uint16_t>(record, 0, 3);  // layered, in chunks of any size
  put<std::uint32_t>(record, 12, UINT32_MAX);
  put<std::int64_t>(record, 16, -1);
  put<std::int64_t>(record, 24, -1);
  put<std::uint16_t>(record, 32, 1);
  push<std::uint16_t>(record, 10);  // an item: points of format 6, version 3
  push<std::uint16_t>(record, record_bytes);
  push<std::uint16_t>(record, 3);
  return record;
}

}  // namespace

Bytes CopcFile::bytes() const {
  const Cube cube = cube_of(points);
  Octree octree(*this, cube);
  octree.add({.level = 0, .key = {}, .points = points});

  LasFile head;
  head.minor = 4;
  head.format = 6;
  head.scale = scale;
  head.offset = offset;
  head.records = {{"copc", 1, Bytes(160)}, {"laszip encoded", 22204, laszip_record()}};
  Bytes file = head.bytes();
  const std::size_t info_at = head.header_bytes() + 54, table_pointer_at = file.size();
  push(file, std::int64_t{0});

  ArithmeticEncoder table;
  IntegerEncoder<32, 2> integers;
  Bytes hierarchy;
  std::int32_t last_points = 0, last_bytes = 0;
  Record lo = points[0], hi = lo;
  for (const Node& node : octree.nodes) {
    for (const Record& p : node.points)
      for (std::size_t axis = 0; axis < 3; ++axis)
        lo[axis] = std::min(lo[axis], p[axis]), hi[axis] = std::max(hi[axis], p[axis]);
    const Bytes chunk = chunk_of(node.points);
    const auto count = static_cast<std::int32_t>(node.points.size()), size = static_cast<std::int32_t>(chunk.size());
    push(hierarchy, node.level);
    for (const std::int32_t k : node.key) push(hierarchy, k);
    push(hierarchy, static_cast<std::uint64_t>(file.size()));
    push(hierarchy, size);
    push(hierarchy, count);
    integers.next(table, last_points, count, 0);
    integers.next(table, last_bytes, size, 1);
    last_points = count;
    last_bytes = size;
    file.insert(file.end(), chunk.begin(), chunk.end());
  }
  put(file, table_pointer_at, static_cast<std::int64_t>(file.size()));
  push(file, std::uint32_t{0});
  push(file, static_cast<std::uint32_t>(octree.nodes.size()));
  const Bytes coded = table.finish();
  file.insert(file.end(), coded.begin(), coded.end());

  const double half = static_cast<double>(cube.side) / 2;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    put(file, info_at + 8 * axis, (static_cast<double>(cube.lo[axis]) + half) * scale[axis] + offset[axis]);
    put(file, 179 + 16 * axis, hi[axis] * scale[axis] + offset[axis]);
    put(file, 187 + 16 * axis, lo[axis] * scale[axis] + offset[axis]);
  }
  put(file, info_at + 24, half * scale[0]);
  put(file, info_at + 32, 2 * half * scale[0] / cells);
  put<std::uint64_t>(file, info_at + 40, file.size());
  put<std::uint64_t>(file, info_at + 48, hierarchy.size());
  put<std::uint8_t>(file, 104, 6 | 0x80);
  put<std::uint64_t>(file, 247, points.size());
  file.insert(file.end(), hierarchy.begin(), hierarchy.end());
  return file;
}

}  // namespace tessera::testing_region

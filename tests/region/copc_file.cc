#include "tests/region/copc_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_set>
#include <utility>

#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/las_copy/integer_encoder.h"
#include "src/input/las_copy/laz_body.h"
#include "tests/input/las_file.h"

namespace tessera::testing_region {

using laz::ArithmeticEncoder;
using laz::IntegerEncoder;
using testing_io::LasFile;
using testing_io::push;
using testing_io::put;

namespace {

using Record = std::array<std::int32_t, 3>;
constexpr std::uint16_t record_bytes = 30;
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

laz::LazLayout layout() { return laz::standard_layout(6, record_bytes, UINT32_MAX); }

// A chunk of ground points, each the only return of its pulse.
Bytes chunk_of(const std::vector<Record>& points) {
  Bytes records(points.size() * record_bytes);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::size_t at = i * record_bytes;
    for (std::size_t axis = 0; axis < 3; ++axis) put(records, at + 4 * axis, points[i][axis]);
    put<std::uint8_t>(records, at + 14, 0x11);
    put<std::uint8_t>(records, at + 16, 2);
  }
  const auto encoder = laz::make_chunk_encoder(layout(), record_bytes);
  encoder->encode(records);
  return encoder->finish();
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
  head.records = {{"copc", 1, Bytes(160)}, {"laszip encoded", 22204, laz::laszip_payload(layout(), {})}};
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

// The nodes of a cloud in EPT: an octree, whose hierarchy is in several files.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/ept/ept_info.h"

namespace tessera::ept {

// The place of a node: its level, and the numbers of its cube in x, y and z.
struct Key {
  std::int32_t level = 0;
  std::array<std::int32_t, 3> at{};
  friend auto operator<=>(const Key&, const Key&) = default;

  std::string text() const;  // "3-4-4-7"
};

struct Node {
  Key key;
  std::uint64_t first = 0, points = 0;  // the number of the first point in the cloud
};

// The nodes with points, in the order of the cloud: by level, then by x, y and z. The whole hierarchy is read, because
// numbers of points are its sums. `ept`: the source of ept.json. Errors: those of reading; bad_input for texts that are
// no hierarchy, nodes without a parent, files in a circle, and a sum that is not that of ept.json.
Result<std::vector<Node>> read_nodes(const ByteSource& ept, const Info& info);

// The number of levels that `resolution` needs (see ReadHints).
std::int32_t levels_for(const Info& info, double resolution);

// The cube of a node within the box of the cloud, a little larger for rounding.
Bounds bounds_of(const Info& info, const Key& key);

// The files of an EPT folder.
std::filesystem::path tile_file(const Info& info, const Key& key);
std::filesystem::path hierarchy_file(const Info& info, const Key& key);

}  // namespace tessera::ept

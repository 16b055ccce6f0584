// NDnet of DisPerSE with a limit that tests can lower.
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>

#include "src/result/export/mesh_source.h"

namespace tessera::exports {

inline constexpr std::uint64_t ndnet_most = std::numeric_limits<std::int32_t>::max();

// Writes the vertices and cells of a result. Vertices are numbered by their ids. Coordinates are rounded to floats;
// fields are doubles: `field_value`, the first of options.names or `density`, its natural logarithm
// `log_field_value`, and the other columns. In a periodic result each point is one vertex. REQUIRES: `most` is at most
// ndnet_most; less only in tests. Errors: usage for more than `most` vertices or cells, without a field, and when a
// cell has two images of one point, or two cells have the same points; those of PointTable.
Result<Exported> write_ndnet_file(const MeshSource& source, const std::filesystem::path& path,
                                  std::uint64_t most = ndnet_most);

}  // namespace tessera::exports

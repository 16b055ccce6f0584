// Writes polyhedra as VTK's unstructured grid. Corners with equal coordinates are one point of the file, whichever
// cells have them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/attribute.h"
#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/export/output.h"
#include "src/result/store/external_sort.h"
#include "src/result/voronoi/cell_file.h"

namespace tessera::voronoi {

struct VtuCellsOptions {
  ResultStamp stamp;              // of the result
  std::vector<Attribute> schema;  // of the points
  std::uint64_t memory_bytes = 0;
  std::stop_token stop = {};
};

// Error usage when the name does not end in .vtu.
Status check_vtu_ending(const std::filesystem::path& target);
// Scratch files stand beside the target. Errors: io; interrupted.
Result<std::unique_ptr<CellFile>> create_vtu_cells(const std::filesystem::path& target, const VtuCellsOptions& options);

}  // namespace tessera::voronoi

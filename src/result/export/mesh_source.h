// What an export reads: a result, its format and the options.
#pragma once

#include <filesystem>
#include <stop_token>

#include "src/result/export/cell_filter.h"
#include "src/result/export/export.h"
#include "src/result/export/formats.h"
#include "src/result/tile_source.h"

namespace tessera::exports {

struct MeshSource {
  const std::filesystem::path& out;
  const TileSource* tiles;  // null: the cells are in memory
  const Manifest& manifest;
  const Format& format;
  const ExportOptions& options;
  CellFilter filter;
  std::stop_token stop = {};
};

}  // namespace tessera::exports

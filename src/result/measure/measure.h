// Computes measures of the cells and vertices of a result, as columns of a new version.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"

namespace tessera {

struct MeasureOptions {
  // The volume of each cell, and for each vertex the sum over the cells around it; in 2D areas in the plane.
  bool volume = false;
  // The shape of each cell: radius ratio, angles, circumradius (cell_quality.h).
  bool quality = false;
  // The Voronoi cell of each vertex: volume, surface, number of neighbours, centroid; in 2D area and boundary.
  bool voronoi = false;
  // The density of each vertex by its star (star_density.h): of the points, or of the masses in the attribute `mass`.
  bool density = false;
  std::string mass = {};
  std::uint64_t memory_bytes = 0;         // at least the memory of one tile is used
  unsigned threads = 0;                   // 0: one
  std::vector<std::string> command = {};  // for the manifest
  std::string software_version = {};
  LockOptions lock = {};  // of the result folder
  // Called with the fraction that is done, 0..1, by one thread at a time; may be null.
  std::function<void(double)> progress = {};
};

struct Measured {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result, after the call
  bool made = true;           // false: the columns existed already, and nothing was changed
  struct Column {
    std::string name;
    bool of_cells = false;  // else of vertices
  };
  std::vector<Column> columns;  // all that were asked for
  // The sum of the volumes or areas of all cells, rounded once, if volumes were asked for. It depends only on the
  // triangulation.
  std::optional<double> total = {};
  std::string total_of;        // "volume" or "area"
  std::string unit;            // of the total: "metre^3"; "" when unknown
  std::uint64_t infinite = 0;  // cells and vertices with values too large for a double
  std::string note;            // a remark about the values; else empty
};

// Error usage when there is nothing to measure.
Status check_measure_options(const MeasureOptions& options);

// Errors: that of check_measure_options(); usage when an attribute has the name of a column, and when another process
// works in the folder; io, also when the disk has too little room for a new version; corrupt; memory; interrupted.
Result<Measured> measure(const std::filesystem::path& out, const MeasureOptions& options, std::stop_token stop);

// One line of JSON.
std::string to_json(const Measured& measured);

}  // namespace tessera

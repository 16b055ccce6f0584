// Computes measures of the cells and vertices of a result, as columns of a new version.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct MeasureOptions {
  // The volume of each cell, and for each vertex the sum over the cells around it; in 2D areas in the plane.
  bool volume = false;
  std::uint64_t memory_bytes = 0;         // at least the memory of one tile is used
  unsigned threads = 0;                   // 0: one
  std::vector<std::string> command = {};  // for the manifest
  std::string software_version = {};
  // Called with the fraction that is done, 0..1, by one thread at a time; may be null.
  std::function<void(double)> progress = {};
};

struct Measured {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result, after the call
  bool made = true;           // false: the columns existed already, and nothing was changed
  std::string of_cells;       // the names of the columns
  std::string of_vertices;
  double total = 0;            // over all cells, rounded once; depends only on the triangulation
  std::string unit;            // "metre^3"; "" when unknown
  std::uint64_t infinite = 0;  // cells and vertices with values too large for a double
  std::string note;            // a remark about the values; else empty
};

// Errors: usage when there is nothing to measure, when an attribute has the name of a column, and when another process
// works in the folder; io, also when the disk has too little room for a new version; corrupt; memory; interrupted.
Result<Measured> measure(const std::filesystem::path& out, const MeasureOptions& options, std::stop_token stop);

// One line of JSON.
std::string to_json(const Measured& measured);

}  // namespace tessera

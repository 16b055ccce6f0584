// What cells and vertices of a result measure, as columns of a new version of it.
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
  // The volume of each cell, and of each vertex that of the cells around it; in 2D areas in the plane.
  bool volume = false;
  std::uint64_t memory_bytes = 0;         // at least what a tile takes is used
  unsigned threads = 0;                   // 0: one
  std::vector<std::string> command = {};  // for the manifest
  std::string software_version = {};
  // Told the part that is done, by one thread at a time; or null.
  std::function<void(double)> progress = {};
};

struct Measured {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result, from now on
  bool made = true;           // else the columns were there already, and nothing was changed
  std::string of_cells;       // the names of the columns
  std::string of_vertices;
  double total = 0;            // over all cells, rounded once: a function of the triangulation alone
  std::string unit;            // "metre^3"; "" when nobody knows
  std::uint64_t infinite = 0;  // cells and vertices whose value is beyond what a double holds
  std::string note;            // what there is to say about the values; else empty
};

// Errors: usage when nothing is to be measured, for a name that an attribute has, and when another process works in the
// folder; io, also when the disk has too little room for a new version; corrupt, memory, interrupted.
Result<Measured> measure(const std::filesystem::path& out, const MeasureOptions& options, std::stop_token stop);

// One line.
std::string to_json(const Measured& measured);

}  // namespace tessera

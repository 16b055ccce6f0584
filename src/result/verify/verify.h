// Proves a result folder, independently of how it was made.
// By the Delaunay lemma a closed complex that is locally Delaunay, positively oriented and bounded by its convex hull
// is the Delaunay triangulation of its vertices; ties are checked with the perturbation's rule, so it is *the* one.
// And everything else that the manifest says of it and that can be known from its files is compared with them: the
// master file, boxes, bounds, attributes, sizes, digest. Where it came from (inputs, command, CRS, times) cannot be.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct VerifyOptions {
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;  // facets beyond this are sorted on disk
  std::filesystem::path scratch;                        // where; default: the system's temporary folder
  bool against_cgal = false;  // also build the global triangulation in memory and compare the sets of cells
};

struct VerifyReport {
  std::uint64_t cells = 0, facets = 0, hull_facets = 0, vertices = 0;
  std::vector<std::string> passed;  // one line a check
};

// What the command prints and a job's outcome holds: one line of JSON without its end. `result`: what it is called
// there.
std::string to_json(const VerifyReport& report, const std::string& result);

// Error not_delaunay tells the first violation (tile, cell, vertices); corrupt a damaged file; both name the place.
Result<VerifyReport> verify(const std::filesystem::path& out, const VerifyOptions& options, std::stop_token stop);

}  // namespace tessera

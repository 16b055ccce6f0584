// Proves a result folder correct, independently of how it was made. By the Delaunay lemma, a closed complex is the
// Delaunay triangulation of its vertices if it is locally Delaunay, positively oriented and bounded by its convex hull.
// Ties are checked with the rule of the perturbation, so the result is *the* perturbed Delaunay triangulation. verify()
// also compares the files with everything else that the manifest says and that can be known from the files: master
// file, boxes, bounds, attributes, sizes, digest. The origin of the result (inputs, command, CRS, times) cannot be
// checked.
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
  std::filesystem::path scratch;                        // for sorting; default: the system's temporary folder
  bool against_cgal = false;  // also triangulate all vertices in memory and compare the sets of cells
};

struct VerifyReport {
  std::uint64_t cells = 0, facets = 0, hull_facets = 0, vertices = 0;
  std::vector<std::string> passed;  // one line a check
};

// One line of JSON, without its end, for the command's output and a job's outcome. `result` is the name of the result
// in that line.
std::string to_json(const VerifyReport& report, const std::string& result);

// Errors: not_delaunay, with the first violation (tile, cell, vertices); corrupt for a damaged file, with the place.
Result<VerifyReport> verify(const std::filesystem::path& out, const VerifyOptions& options, std::stop_token stop);

}  // namespace tessera

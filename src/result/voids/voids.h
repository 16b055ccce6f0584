// Voids: the watershed of the density of a result, as ZOBOV defines it.
//
// A vertex flows to the Delaunay neighbour of the lowest density, if that is lower than its own. What flows to one
// vertex without a lower neighbour, the core, is a zone. A void is what water floods that rises over the core of a
// zone, until it would flow into a zone with a lower core (zone_graph.h). Of equal densities that of the lower source
// index counts as lower. Vertices with unbounded Voronoi cells are in no zone.
// Source: Neyrinck, ZOBOV: a parameter-free void-finding algorithm, MNRAS 386 (2008).
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/files/folder_lock.h"
#include "src/base/result.h"
#include "src/result/voids/void_files.h"

namespace tessera::voids {

struct VoidsOptions {
  // The density: "voronoi", 1 over the volume of the Voronoi cell; or the column "density" or "density_NAME".
  std::string by = "voronoi";
  std::filesystem::path target = {};  // the file of voids (void_files.h); may be empty
  bool overwrite = false;
  std::uint64_t memory_bytes = 0;         // at least the memory of one tile is used; zones need memory beside it
  unsigned threads = 0;                   // 0: one
  std::vector<std::string> command = {};  // for the manifest
  std::string software_version = {};
  LockOptions lock = {};  // of the result folder
  // Called with the fraction that is done, 0..1, by one thread at a time; may be null.
  std::function<void(double)> progress = {};
};

struct Found {
  std::filesystem::path folder;
  std::uint32_t version = 1;  // of the result, after the call
  bool made = true;           // false: the column existed already, and the result was not changed
  std::string column;         // of vertices: the source index of the core of the vertex's zone; -1: in no zone
  std::uint64_t zones = 0;
  std::uint64_t points = 0;                  // in zones, duplicates included
  std::uint64_t outside = 0;                 // vertices that are in no zone
  std::vector<std::filesystem::path> files;  // that were written
  std::string unit;                          // of volumes: "metre^3"; "" when unknown
};

struct FoundVoids {
  Found found;
  VoidTable table;
};

// Error usage for a name that is no density, and for a target that cannot be written.
Status check_voids_options(const VoidsOptions& options);

// Computes the columns that the density needs, if the result lacks them (a version of its own), then the zones, as a
// column `zone` (of another density than Voronoi's `zone_` and its name) of a new version, unless the result has it;
// and writes the target. All files get their names when all is computed. The values depend only on the triangulation
// and the columns. Errors: those of check_voids_options() and measure(), such as for a region; usage when the name of
// the column is taken; bad_input for a density that is negative or NaN; corrupt; io; memory; interrupted.
Result<FoundVoids> find_voids(const std::filesystem::path& out, const VoidsOptions& options, std::stop_token stop);

// One line of JSON, without its end, for the command's output.
std::string to_json(const Found& found);

}  // namespace tessera::voids

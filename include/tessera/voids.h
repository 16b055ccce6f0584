// Voids: watershed zones of the density of a result, their saddles and hierarchy, as ZOBOV defines them
// (docs/voids.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// Options of Triangulation::find_voids(). Every function returns *this.
class TESSERA_PUBLIC VoidsRequest {
 public:
  VoidsRequest();
  VoidsRequest(const VoidsRequest&);
  VoidsRequest& operator=(const VoidsRequest&);
  ~VoidsRequest();

  // The density of a vertex: "voronoi", the default, 1 over the volume of its Voronoi cell; "density" or
  // "density_NAME", the columns of Triangulation::measure().
  VoidsRequest& by(const std::string& density);
  // A file to write: a .csv, or a .txt for the files .txt, .zone and .void of ZOBOV.
  VoidsRequest& output(const std::filesystem::path& target);
  // Replaces existing files.
  VoidsRequest& overwrite(bool overwrite);
  // The memory for tiles; 0, the default: 70 % of the free memory.
  VoidsRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  VoidsRequest& threads(unsigned threads);
  VoidsRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A zone and its void. Densities and volumes (in 2D areas) are in the unit of the coordinates. Programs are compiled
// with the size of this struct, so it never changes.
struct FoundVoid {
  std::int64_t zone = 0;  // the source index of the zone's core
  double core_density = 0, x = 0, y = 0, z = 0;
  std::int64_t zone_points = 0;
  double zone_volume = 0;
  std::int64_t saddle_vertex = -1;  // at which the void flows out; -1: nowhere
  double saddle_density = 0;        // without a saddle the highest density of all
  std::int64_t parent = -1;         // the zone of whose void this one is a part; -1: none
  std::int64_t void_zones = 1, void_points = 0;
  double void_volume = 0, contrast = 1, probability = 1;
};

// Programs are compiled with the size of this struct, so it never changes.
struct FoundVoids {
  std::string column;            // of vertices: the source index of the core of the vertex's zone; -1: in none
  bool made = true;              // false: the result had the column already
  std::uint64_t outside = 0;     // vertices in no zone
  std::vector<FoundVoid> voids;  // by zone
};

}  // namespace tessera

// Voids as files: a table, and the three text files of ZOBOV.
//
// .csv has a line of names of columns, then a line a void, the greatest density contrast first. Numbers have so many
// digits that the same doubles are read back. Unit of densities and volumes: that of the result.
//
// NAME.txt, NAME.zone and NAME.void are laid out as by jozov, the last program of ZOBOV, in its version with text files
// (REVOLVER, github.com/seshnadathur/Revolver). Zones are numbered in the order of their cores' source indices.
//   .txt   "N particles, M voids", a line of names, then a line a void, the greatest density contrast first. Densities
//          are in units of the mean, and volumes are, too: the mean volume of a Voronoi cell of those in zones is 1.
//   .zone  "N M", then the number of the zone of each source index, from 0 on; -1: in no zone
//   .void  "M", then a line a zone: its number; for each saddle over which the void grows the number of zones that it
//          adds, the density of the saddle divided by that of the core, and these zones; then 0 and the void's density
//          contrast
#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "src/base/files/output_file.h"
#include "src/base/ids.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/tile_store.h"
#include "src/result/voids/zone_graph.h"

namespace tessera::voids {

// A zone and its void, in the unit of the result.
struct VoidRow {
  PointId core;
  Point place;  // of the core
  double core_density = 0;
  std::uint64_t zone_points = 0;
  double zone_volume = 0;
  std::uint64_t zones = 1, points = 0;  // of the void
  double volume = 0;
  std::optional<PointId> saddle;  // the vertex at which the void flows out: the denser end of an edge
  double saddle_density = 0;      // without a saddle the highest density of all vertices in zones
  ZoneNumber parent = no_zone;    // the zone with the deepest core of those that join at the saddle
  double contrast = 1;            // the saddle's density, divided by the core's
  double probability = 1;
};

// By zone.
struct VoidTable {
  int dimension = 3;
  std::vector<VoidRow> rows;
};

// Error usage when the name of the file ends neither in .csv nor in .txt, and when a file that would be written exists
// and `overwrite` is not set.
Status check_voids_target(const std::filesystem::path& target, bool overwrite);
// The files that write_voids() writes.
std::vector<std::filesystem::path> files_of(const std::filesystem::path& target);

// The zones of all source indices, in files of some millions each, so that they need not fit into memory. add() is safe
// to call from several threads.
class ZonesByPoint {
 public:
  // `scratch`: a folder, for files. `duplicates` of the result; `points`: of the input, or fewer.
  ZonesByPoint(std::filesystem::path scratch, std::vector<DuplicatePair> duplicates, std::uint64_t points);
  // The zones of own vertices of a tile. Errors: io.
  Status add(std::span<const PointId> vertices, std::span<const ZoneNumber> zones);
  // Writes a line for each source index. Errors: io.
  Status write(OutputFile& file, std::size_t zones) const;
  // How many source indices there are.
  std::uint64_t points() const { return points_; }

 private:
  struct Entry {
    PointId point;
    ZoneNumber zone = no_zone;
    std::uint32_t unused = 0;
  };
  static constexpr std::uint64_t points_a_file = std::uint64_t{1} << 21;
  Status append(std::vector<Entry> entries);

  std::filesystem::path scratch_;
  std::vector<DuplicatePair> duplicates_;  // by kept vertex
  std::mutex mutex_;
  std::uint64_t points_ = 0;  // one more than the greatest source index
};

// Writes the files of `target` under temporary names; `commit()` of each gives it its name. REQUIRES: `points` for
// .txt. Errors: io.
Result<std::vector<OutputFile>> write_voids(const VoidTable& table, const std::filesystem::path& target,
                                            const ZonesByPoint* points);

}  // namespace tessera::voids

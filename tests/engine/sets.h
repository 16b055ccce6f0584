// The clouds of the product: every set of gen.py and every real file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::testing {

struct CloudSet {
  std::string name;  // of the set or file
  std::filesystem::path source;
  int stored_dimension = 3;     // of the file
  std::uintmax_t weight = 0;    // bytes of coordinates: the order of the product
  bool generated = false;       // by gen.py
  std::vector<int> dimensions;  // to triangulate in
};

// The sets in `generated` (gen.py all) and the .las, .ply, .xyz, .csv, .bin and .bin2 files in the folders `real`, of
// which some need not exist, smallest first. A file that is another one's twin in plain doubles (a .bin beside a .las)
// is left out, and so is one whose name a folder before has.
std::vector<CloudSet> cloud_sets(const std::filesystem::path& generated,
                                 const std::vector<std::filesystem::path>& real);

// What the engine is given: the set's own file, or for .bin and .bin2, which it does not read, a copy as .npy in
// `folder`.
Result<std::filesystem::path> readable_file(const CloudSet& set, const std::filesystem::path& folder);

// All points in file order, ids by rank, z dropped in 2D, without -0; non-finite ones included.
Result<std::vector<LocalPoint>> read_points(const CloudSet& set, int dimension);

// An n x d array of doubles, as NumPy writes it.
Status write_npy(const std::filesystem::path& path, int dimension, const std::vector<double>& coordinates);

}  // namespace tessera::testing

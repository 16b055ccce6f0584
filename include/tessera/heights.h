// Heights above the ground, in copies of LAS and LAZ files (docs/terrain.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/visibility.h"

namespace tessera {

// The options of write_heights(), which are those of `tessera hag`. Every function returns *this.
class TESSERA_PUBLIC HeightsRequest {
 public:
  HeightsRequest();
  HeightsRequest(const HeightsRequest&);
  HeightsRequest& operator=(const HeightsRequest&);
  ~HeightsRequest();

  // The ground, as a 2D result in this folder. By default it is made of the ground points of all files, and removed
  // afterwards.
  HeightsRequest& ground(const std::filesystem::path& result);
  // The class of the ground points; 2 by default.
  HeightsRequest& ground_class(int number);
  // "las" or "laz"; by default each copy is as its file.
  HeightsRequest& format(const std::string& name);
  // The height of points outside of the hull of the ground; NaN by default.
  HeightsRequest& outside(double height);
  // Replaces a dimension HeightAboveGround that a file has already.
  HeightsRequest& replace(bool replace);
  // Replaces copies that exist.
  HeightsRequest& overwrite(bool overwrite);
  // The memory for tiles; 0, the default: 70 % of the free memory.
  HeightsRequest& memory_bytes(std::uint64_t bytes);
  // 0, the default: all processors.
  HeightsRequest& threads(unsigned threads);
  HeightsRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// A file and its copy. Only the library makes objects of this type, and later versions may append members.
struct CopyWithHeights {
  std::filesystem::path input, output;
  std::uint64_t points = 0;
  std::uint64_t outside = 0;  // of them, outside of the hull of the ground
};

// Copies LAS and LAZ files into `folder`, and gives each point the dimension HeightAboveGround: its z minus the height
// of the ground, linear in the triangle that contains it. Everything else in the files stays as it is. Failure: usage,
// also for copies that exist; bad_input for files that are not LAS or LAZ, or have the dimension; memory, io, corrupt,
// interrupted. Each copy appears when it is complete.
TESSERA_PUBLIC std::vector<CopyWithHeights> write_heights(const std::vector<std::string>& inputs,
                                                          const std::filesystem::path& folder,
                                                          const HeightsRequest& request = {});

}  // namespace tessera

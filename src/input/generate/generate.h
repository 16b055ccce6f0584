// Made-up clouds for tests, benchmarks and demonstrations. The same options give the same bits on every machine.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera {

enum class CloudShape {
  uniform,  // in the unit cube [0, 1)^d, multiples of 2^-53
  normal,   // every coordinate normal with mean 0 and deviation 1
  sphere,   // on the unit sphere around 0, evenly; cospherical up to rounding
  grid,     // integers 0 .. k-1 on each axis, k the least with k^d >= n, x fastest, cut after n points
  terrain,  // terrain.h: airborne LiDAR, centimetre steps
};

std::optional<CloudShape> shape_named(std::string_view name);

struct GenerateOptions {
  CloudShape shape = CloudShape::uniform;
  std::uint64_t points = 0;
  std::uint64_t seed = 1;
  int dimension = 3;  // in 2D: the square, the circle, ...; a terrain without its heights
};

class ShapeSource;

class PointGenerator {
 public:
  explicit PointGenerator(const GenerateOptions& options);
  ~PointGenerator();

  // Replaces both by the next points, 64 Ki or those that are left, and their LAS classes (0 but for terrain).
  void next(std::vector<Point>& points, std::vector<std::uint8_t>& classes);
  // A box that holds all points, known before the first.
  Bounds bounds() const;
  // The coordinates are multiples of this, or 0 if of nothing coarser than a double.
  double step() const;

 private:
  GenerateOptions options_;
  std::uint64_t done_ = 0;
  std::unique_ptr<ShapeSource> source_;
};

// Writes a cloud to a file whose format is its extension: .las .ply .npy .xyz .csv (see writer.h; LAS rounds to a
// step). `keep_going`, if given, is asked after every batch with the number of points written: false ends with
// Errc::interrupted. No file is left unless it is whole.
Status generate(const GenerateOptions& options, const std::filesystem::path& path,
                const std::function<bool(std::uint64_t)>& keep_going = {});

}  // namespace tessera

// Generated clouds for tests, benchmarks and demonstrations. The same options give the same bits on every machine.
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
  uniform,  // in the unit cube [0, 1)^d; multiples of 2^-53
  normal,   // each coordinate is normal with mean 0 and deviation 1
  sphere,   // evenly on the unit sphere around 0; cospherical up to rounding
  grid,     // integers 0 .. k-1 on each axis, with the least k with k^d >= n; x changes fastest; cut off after n points
  terrain,  // see terrain.h: airborne LiDAR in steps of a centimetre
  halos,    // see halos.h: clumps of particles in a periodic cube [0, 1)^d
};

// The shape with this name ("uniform", ...). Nothing for other names.
std::optional<CloudShape> shape_named(std::string_view name);

struct GenerateOptions {
  CloudShape shape = CloudShape::uniform;
  std::uint64_t points = 0;
  std::uint64_t seed = 1;
  int dimension = 3;  // 2: the square, the circle, ..., or a terrain without its heights
};

class ShapeSource;

// Makes the points of a cloud in order. Not thread-safe.
class PointGenerator {
 public:
  explicit PointGenerator(const GenerateOptions& options);
  ~PointGenerator();

  // Replaces `points` by the next points, 64 Ki or those that are left, and `classes` by their LAS classes (0 except
  // for terrain).
  void next(std::vector<Point>& points, std::vector<std::uint8_t>& classes);
  // A box around all points, known before the first point.
  Bounds bounds() const;
  // The coordinates are multiples of this number. 0 if there is no such number.
  double step() const;

 private:
  GenerateOptions options_;
  std::uint64_t done_ = 0;
  std::unique_ptr<ShapeSource> source_;
};

// Writes a cloud to a file. The extension is the format: .las .ply .npy .xyz .csv (see writer.h; LAS rounds to a step).
// `keep_going`, if given, is called after each batch with the number of points written so far. When it returns false,
// generate() ends with Errc::interrupted. No incomplete file is left.
Status generate(const GenerateOptions& options, const std::filesystem::path& path,
                const std::function<bool(std::uint64_t)>& keep_going = {});

}  // namespace tessera

// Lines as a file of maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::terrain {

struct LineFileOptions {
  std::string crs;         // as a manifest has it
  std::string layer;       // its name
  std::string value;       // the name of the lines' attribute beside `index`
  bool heights = true;     // whether that is the lines' height, too
  bool overwrite = false;  // a file that exists
};

// Is there whole, after finish(), or not at all.
class LineFile {
 public:
  // By the target's ending: .gpkg, .geojson, .json. Error usage for another one, a folder, a file that exists.
  static Status check_target(const std::filesystem::path& target, bool overwrite);
  // Errors, here and below: io; bad_input when GDAL does not understand the system.
  static Result<std::unique_ptr<LineFile>> create(const std::filesystem::path& target, const LineFileOptions& options);
  virtual ~LineFile() = default;
  virtual Status add(double value, bool index, std::span<const Point> points) = 0;
  virtual Result<std::uint64_t> finish() = 0;  // the size in bytes
};

}  // namespace tessera::terrain

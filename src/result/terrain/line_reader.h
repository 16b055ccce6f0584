// Reads the lines of a GeoPackage that write_contours() has made, a few at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/crs/gdal_library.h"
#include "src/base/point.h"
#include "src/base/result.h"

namespace tessera::terrain {

class LineReader {
 public:
  // Error usage when the file is not such a GeoPackage; io without GDAL.
  static Result<std::unique_ptr<LineReader>> open(const std::filesystem::path& path);
  ~LineReader();
  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  const std::string& value_name() const { return value_name_; }  // the name of the lines' attribute beside `index`
  std::uint64_t lines() const;                                   // all

  struct Line {
    std::uint64_t number = 0;  // ascending, by level
    double value = 0;
    std::optional<bool> index = {};  // nothing in files of releases that did not write it
    std::vector<Point> points;
  };
  // Passes to `visit`, in ascending order, the lines whose number is above `after` and whose box meets `box`, if there
  // is one, until `visit` returns false. Errors: those of `visit`; io.
  Status for_each(std::uint64_t after, const std::optional<Bounds>& box,
                  const std::function<Result<bool>(Line& line)>& visit) const;

 private:
  LineReader(const GdalLibrary& gdal, GDALDatasetH dataset) : gdal_(gdal), dataset_(dataset) {}

  const GdalLibrary& gdal_;
  GDALDatasetH dataset_;
  OGRLayerH layer_ = nullptr;
  std::string value_name_, index_name_;
};

}  // namespace tessera::terrain

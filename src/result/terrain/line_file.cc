#include "src/result/terrain/line_file.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/crs/crs.h"
#include "src/base/json/json_text.h"
#include "src/base/option.h"
#include "src/result/export/ending.h"
#include "src/result/export/geopackage.h"
#include "src/result/export/output.h"

namespace tessera::terrain {

namespace fs = std::filesystem;

namespace {

// The name of the attribute that marks index lines; names of columns ignore case.
const char* index_field(const std::string& value) {
  constexpr std::string_view name = "index";
  const bool taken = value.size() == name.size() &&
                     std::equal(value.begin(), value.end(), name.begin(),
                                [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
  return taken ? "index_line" : "index";
}

class GeoPackageLines : public LineFile {
 public:
  GeoPackageLines(std::unique_ptr<exports::GeoPackage> file, exports::GeoPackage::Layer layer, bool heights)
      : file_(std::move(file)), layer_(layer), heights_(heights) {}

  Status add(double value, bool index, std::span<const Point> points) override {
    // Little endian, with ISO's type numbers.
    const std::uint32_t head[] = {heights_ ? 1002U : 2U, static_cast<std::uint32_t>(points.size())};
    const std::size_t axes = heights_ ? 3 : 2;
    wkb_.resize(1 + sizeof head + points.size() * axes * sizeof(double));
    wkb_[0] = 1;
    std::memcpy(wkb_.data() + 1, head, sizeof head);
    unsigned char* to = wkb_.data() + 1 + sizeof head;
    for (const Point& p : points) {
      const double place[] = {p.x, p.y, value};
      std::memcpy(to, place, axes * sizeof(double));
      to += axes * sizeof(double);
    }
    file_->gdal().OGR_F_SetFieldDouble(layer_.feature, 0, value);
    file_->gdal().OGR_F_SetFieldInteger64(layer_.feature, 1, index ? 1 : 0);
    return file_->add(layer_, wkb_.data(), wkb_.size());
  }
  Result<std::uint64_t> finish() override { return file_->finish(); }

 private:
  std::unique_ptr<exports::GeoPackage> file_;
  exports::GeoPackage::Layer layer_;
  bool heights_;
  std::vector<unsigned char> wkb_;
};

std::string quoted(const std::string& text) { return json_text(nlohmann::json(text)); }

class GeoJsonLines : public LineFile {
 public:
  GeoJsonLines(exports::OutputFile file, const std::string& crs, const LineFileOptions& options)
      : file_(std::move(file)),
        stream_(file_, 0),
        key_(quoted(options.value)),
        index_key_(quoted(index_field(options.value))),
        heights_(options.heights) {
    stream_.text("{\"type\":\"FeatureCollection\",\"crs\":{\"type\":\"name\",\"properties\":{\"name\":" + quoted(crs) +
                 "}},\"result\":" + json_of(options.stamp) + ",\"features\":[");
  }

  Status add(double value, bool index, std::span<const Point> points) override {
    stream_.text(lines_++ == 0 ? "\n" : ",\n");
    stream_.text("{\"type\":\"Feature\",\"properties\":{" + key_ + ":");
    stream_.digits(value);
    stream_.text("," + index_key_ + (index ? ":true" : ":false"));
    stream_.text("},\"geometry\":{\"type\":\"LineString\",\"coordinates\":[");
    bool first = true;
    for (const Point& p : points) {
      stream_.text(first ? "[" : ",[");
      first = false;
      stream_.digits(p.x);
      stream_.text(",");
      stream_.digits(p.y);
      if (heights_) {
        stream_.text(",");
        stream_.digits(value);
      }
      stream_.text("]");
    }
    stream_.text("]}}");
    return stream_.status();
  }
  Result<std::uint64_t> finish() override {
    stream_.text("\n]}\n");
    BOOST_OUTCOME_TRYV(stream_.flush());
    return file_.finish();
  }

 private:
  exports::OutputFile file_;
  exports::Stream stream_;
  std::string key_, index_key_;
  bool heights_;
  std::uint64_t lines_ = 0;
};

}  // namespace

Status LineFile::check_target(const fs::path& target, bool overwrite) {
  const std::string ending = exports::ending_of(target);
  if (ending != ".gpkg" && ending != ".geojson" && ending != ".json")
    return error(Errc::usage,
                 target.string() + ": will be a GeoPackage or GeoJSON, so give a name that ends in .gpkg or .geojson");
  return exports::check_free(target, overwrite);
}

Result<std::unique_ptr<LineFile>> LineFile::create(const fs::path& target, const LineFileOptions& options) {
  if (exports::ending_of(target) == ".gpkg") {
    BOOST_OUTCOME_TRY(file, exports::GeoPackage::create(target, options.crs, metadata_of(options.stamp)));
    BOOST_OUTCOME_TRY(
        layer,
        file->add_layer(options.layer.c_str(), options.heights ? wkbLineString25D : wkbLineString,
                        {{options.value, OFTReal}, {index_field(options.value), OFTInteger, OFSTBoolean}}, true));
    BOOST_OUTCOME_TRYV(file->begin());
    return std::make_unique<GeoPackageLines>(std::move(file), layer, options.heights);
  }
  BOOST_OUTCOME_TRY(crs, crs_name_or_wkt(options.crs));
  BOOST_OUTCOME_TRY(file, exports::OutputFile::create(target));
  return std::make_unique<GeoJsonLines>(std::move(file), crs, options);
}

}  // namespace tessera::terrain

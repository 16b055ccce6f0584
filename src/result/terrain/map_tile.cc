#include "src/result/terrain/map_tile.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "src/base/crs/lon_lat.h"
#include "src/base/default_arithmetic.h"
#include "src/base/files/descriptor.h"
#include "src/result/terrain/gdal_choices.h"

namespace tessera::terrain {
namespace {

constexpr int side = 256;
constexpr double radius = 6378137, half = std::numbers::pi * radius;  // radius of the sphere, half of the map's width
constexpr double latitude_max = 85.05112877980659;                    // where the map ends

std::string text_of(double number) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof digits, number).ptr};
}

double mercator_y(double latitude) {
  const double at = std::clamp(latitude, -latitude_max, latitude_max) * std::numbers::pi / 180;
  return radius * std::log(std::tan(std::numbers::pi / 4 + at / 2));
}

using Band = std::vector<unsigned char>;

}  // namespace

bool MapTile::exists() const {
  if (level < 0 || level >= levels) return false;
  const std::int64_t count = std::int64_t{1} << level;
  return row >= 0 && row < count && column >= 0 && column < count;
}

Bounds MapTile::bounds() const {
  const double width = 2 * half / static_cast<double>(std::int64_t{1} << level);
  const double left = -half + static_cast<double>(column) * width, top = half - static_cast<double>(row) * width;
  return {{left, top - width, 0}, {left + width, top, 0}};
}

HeightRaster::~HeightRaster() {
  const GdalQuiet quiet(gdal_);
  gdal_.GDALClose(dataset_);
}

Error HeightRaster::refused(const GdalQuiet& quiet) const {
  return error(Errc::io, path_ + ": no map can be drawn of it: " + quiet.message());
}

Result<std::unique_ptr<HeightRaster>> HeightRaster::open(const std::filesystem::path& path) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const DefaultArithmetic kept;
  const GdalQuiet quiet(*gdal);
  const auto no_raster = [&](const std::string& why) { return error(Errc::usage, path.string() + ": " + why); };
  if (!check_regular(path)) return no_raster("is not a raster");  // GDAL would wait for a named pipe
  const char* const drivers[] = {"GTiff", nullptr};
  const GDALDatasetH dataset =
      gdal->GDALOpenEx(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers, nullptr, nullptr);
  if (dataset == nullptr) return no_raster("is not a raster");
  auto raster = std::unique_ptr<HeightRaster>(new HeightRaster(*gdal, dataset));
  raster->path_ = path.string();
  const auto type = gdal->GDALGetRasterDataType(gdal->GDALGetRasterBand(dataset, 1));
  double transform[6] = {};
  if (gdal->GDALGetRasterCount(dataset) != 1 || (type != GDT_Float32 && type != GDT_Float64) ||
      gdal->GDALGetGeoTransform(dataset, transform) != CE_None)
    return no_raster("is not a raster of heights");
  const auto places = LonLat::of(gdal->GDALGetProjectionRef(dataset));
  if (!places) return places.error().code == Errc::io ? places.error() : no_raster(places.error().where);
  const double right = transform[0] + transform[1] * gdal->GDALGetRasterXSize(dataset);
  const double bottom = transform[3] + transform[5] * gdal->GDALGetRasterYSize(dataset);
  const auto box = places.value().box_to({{transform[0], bottom, 0}, {right, transform[3], 0}});
  if (!box) return no_raster(box.error().where);
  raster->extent_ = {box.value().lo.x, box.value().lo.y, box.value().hi.x, box.value().hi.y};
  const double degree = half / 180;
  raster->box_ = {{box.value().lo.x * degree, mercator_y(box.value().lo.y), 0},
                  {box.value().hi.x * degree, mercator_y(box.value().hi.y), 0}};
  raster->system_ = places.value().wkt();
  return raster;
}

// Heights as floats; NaN where there is no height.
Result<GDALDatasetH> HeightRaster::warped(const Bounds& bounds, int pixels) const {
  const GdalQuiet quiet(gdal_);
  const std::string width = std::to_string(pixels);
  Choices choices({"-of",
                   "MEM",
                   "-ot",
                   "Float32",
                   "-s_srs",
                   system_,
                   "-t_srs",
                   "EPSG:3857",
                   "-novshift",
                   "-r",
                   "bilinear",
                   "-dstnodata",
                   "nan",
                   "-te",
                   text_of(bounds.lo.x),
                   text_of(bounds.lo.y),
                   text_of(bounds.hi.x),
                   text_of(bounds.hi.y),
                   "-ts",
                   width,
                   width});
  GDALWarpAppOptions* options = gdal_.GDALWarpAppOptionsNew(choices.get(), nullptr);
  if (options == nullptr) return refused(quiet);
  GDALDatasetH source = dataset_;
  const GDALDatasetH made = gdal_.GDALWarp("", nullptr, 1, &source, options, nullptr);
  gdal_.GDALWarpAppOptionsFree(options);
  if (made == nullptr) return refused(quiet);
  return made;
}

Result<std::string> HeightRaster::draw(const MapTile& tile, MapStyle style) const {
  const DefaultArithmetic kept;
  const GdalQuiet quiet(gdal_);
  const Bounds bounds = tile.bounds();
  constexpr std::size_t all = side * side;
  const std::size_t bands = style == MapStyle::hillshade ? 2 : 4;
  std::vector<Band> image(bands, Band(all, 0));
  if (bounds.hi.x < box_.lo.x || box_.hi.x < bounds.lo.x || bounds.hi.y < box_.lo.y || box_.hi.y < bounds.lo.y)
    return png(image);
  // With one more pixel around, because the light needs the slopes there.
  const double pixel = (bounds.hi.x - bounds.lo.x) / side;
  const Bounds wider{{bounds.lo.x - pixel, bounds.lo.y - pixel, 0}, {bounds.hi.x + pixel, bounds.hi.y + pixel, 0}};
  BOOST_OUTCOME_TRY(heights, warped(wider, side + 2));
  GDALDatasetH drawn = heights;
  if (style == MapStyle::hillshade) {
    // The scale by which the map is larger than the ground.
    const double scale = std::cosh((bounds.lo.y + bounds.hi.y) / 2 / radius);
    Choices choices({"-of", "MEM", "-compute_edges", "-z", text_of(scale)});
    GDALDEMProcessingOptions* options = gdal_.GDALDEMProcessingOptionsNew(choices.get(), nullptr);
    drawn = gdal_.GDALDEMProcessing("", heights, "hillshade", nullptr, options, nullptr);
    gdal_.GDALDEMProcessingOptionsFree(options);
  }
  const auto read = [&](GDALDatasetH from, void* to, GDALDataType type) {
    return from != nullptr && gdal_.GDALRasterIO(gdal_.GDALGetRasterBand(from, 1), GF_Read, 1, 1, side, side, to, side,
                                                 side, type, 0, 0) == CE_None;
  };
  std::vector<float> values(all, std::numeric_limits<float>::quiet_NaN());
  bool good = read(heights, values.data(), GDT_Float32);
  if (style == MapStyle::hillshade) good = good && read(drawn, image[0].data(), GDT_Byte);
  if (drawn != heights && drawn != nullptr) gdal_.GDALClose(drawn);
  gdal_.GDALClose(heights);
  if (!good) return refused(quiet);
  for (std::size_t i = 0; i < all; ++i) {
    if (std::isnan(values[i])) {
      if (style == MapStyle::hillshade) image[0][i] = 0;
      continue;
    }
    image[bands - 1][i] = 255;
    if (style == MapStyle::hillshade) continue;
    const auto code = static_cast<std::uint32_t>(
        std::lround(std::clamp((static_cast<double>(values[i]) + 10'000) * 10, 0.0, 16'777'215.0)));
    image[0][i] = static_cast<unsigned char>(code >> 16);
    image[1][i] = static_cast<unsigned char>(code >> 8 & 255);
    image[2][i] = static_cast<unsigned char>(code & 255);
  }
  return png(image);
}

Result<std::string> HeightRaster::png(const std::vector<Band>& bands) const {
  const GdalQuiet quiet(gdal_);
  const GDALDriverH memory = gdal_.GDALGetDriverByName("MEM"), writer = gdal_.GDALGetDriverByName("PNG");
  if (memory == nullptr || writer == nullptr) return error(Errc::io, "this GDAL cannot write PNG");
  const GDALDatasetH image =
      gdal_.GDALCreate(memory, "", side, side, static_cast<int>(bands.size()), GDT_Byte, nullptr);
  if (image == nullptr) return refused(quiet);
  bool good = true;
  for (std::size_t b = 0; b < bands.size(); ++b)
    good =
        good && gdal_.GDALRasterIO(gdal_.GDALGetRasterBand(image, static_cast<int>(b) + 1), GF_Write, 0, 0, side, side,
                                   const_cast<unsigned char*>(bands[b].data()), side, side, GDT_Byte, 0, 0) == CE_None;
  // The name belongs to this reader alone, which one thread uses.
  const std::string file = "/vsimem/tessera-" + std::to_string(reinterpret_cast<std::uintptr_t>(this)) + ".png";
  Choices choices({"ZLEVEL=6"});
  const GDALDatasetH written =
      good ? gdal_.GDALCreateCopy(writer, file.c_str(), image, 0, choices.get(), nullptr, nullptr) : nullptr;
  gdal_.GDALClose(image);
  if (written == nullptr) return refused(quiet);
  gdal_.GDALClose(written);
  vsi_l_offset bytes = 0;
  GByte* content = gdal_.VSIGetMemFileBuffer(file.c_str(), &bytes, 1);
  if (content == nullptr) return refused(quiet);
  std::string text(reinterpret_cast<const char*>(content), static_cast<std::size_t>(bytes));
  gdal_.VSIFree(content);
  return text;
}

}  // namespace tessera::terrain

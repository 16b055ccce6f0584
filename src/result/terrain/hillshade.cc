#include "src/result/terrain/hillshade.h"

#include <charconv>
#include <limits>
#include <memory>

#include "src/base/crs/gdal_library.h"
#include "src/result/terrain/gdal_choices.h"

namespace tessera::terrain {
namespace {

int CPL_STDCALL go_on(double, const char*, void* stop) {
  return static_cast<const std::stop_token*>(stop)->stop_requested() ? 0 : 1;
}

}  // namespace

std::vector<std::string> hillshade_words(const Light& light) {
  const auto number = [](double degrees) {
    char digits[32];
    return std::string(digits, std::to_chars(digits, digits + sizeof digits, degrees).ptr);
  };
  return {"-compute_edges", "-az", number(light.azimuth), "-alt", number(light.altitude)};
}

Status shade(DemArray& array, double res, const Light& light, const std::stop_token& stop) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  const GdalQuiet quiet(*gdal);
  const auto refused = [&] { return error(Errc::io, "the hillshade cannot be made: " + quiet.message()); };
  const auto close = [&](void* dataset) { gdal->GDALClose(dataset); };
  using Dataset = std::unique_ptr<void, decltype(close)>;
  const int width = static_cast<int>(array.width), height = static_cast<int>(array.height);
  // With 32 bits, as in the files of which the command makes a hillshade.
  const Dataset heights(gdal->GDALCreate(gdal->GDALGetDriverByName("MEM"), "", width, height, 1, GDT_Float32, nullptr),
                        close);
  if (!heights) return refused();
  const auto transfer = [&](const Dataset& dataset, GDALRWFlag way) {
    return gdal->GDALRasterIO(gdal->GDALGetRasterBand(dataset.get(), 1), way, 0, 0, width, height, array.values.data(),
                              width, height, GDT_Float64, 0, 0) == CE_None;
  };
  double transform[] = {array.left, res, 0, array.top, 0, -res};
  if (gdal->GDALSetGeoTransform(heights.get(), transform) != CE_None ||
      gdal->GDALSetRasterNoDataValue(gdal->GDALGetRasterBand(heights.get(), 1),
                                     std::numeric_limits<double>::quiet_NaN()) != CE_None ||
      !transfer(heights, GF_Write))
    return refused();
  std::vector<std::string> words = hillshade_words(light);
  words.insert(words.end(), {"-of", "MEM"});
  Choices choices(std::move(words));
  GDALDEMProcessingOptions* options = gdal->GDALDEMProcessingOptionsNew(choices.get(), nullptr);
  if (options == nullptr) return refused();
  gdal->GDALDEMProcessingOptionsSetProgress(options, go_on, const_cast<std::stop_token*>(&stop));
  const Dataset shaded(gdal->GDALDEMProcessing("", heights.get(), "hillshade", nullptr, options, nullptr), close);
  gdal->GDALDEMProcessingOptionsFree(options);
  if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while shading the raster");
  if (!shaded || !transfer(shaded, GF_Read)) return refused();
  array.pixels = 0;
  for (double& pixel : array.values) {
    if (pixel == 0) {
      pixel = std::numeric_limits<double>::quiet_NaN();
    } else {
      ++array.pixels;
    }
  }
  return success();
}

}  // namespace tessera::terrain

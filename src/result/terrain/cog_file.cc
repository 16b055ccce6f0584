#include "src/result/terrain/cog_file.h"

#include <algorithm>
#include <limits>
#include <system_error>
#include <utility>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/base/ledger.h"
#include "src/result/terrain/gdal_choices.h"
#include "src/result/terrain/hillshade.h"

namespace tessera::terrain {

namespace fs = std::filesystem;

namespace {

// A file that GDAL writes without src/base/files. Its growth is drawn from the thread's ledger.
class Growing {
 public:
  explicit Growing(const fs::path& path) : path_(path) {}
  Status draw() {
    BOOST_OUTCOME_TRY(there, bytes_if_there(path_));
    const std::uint64_t bytes = there.value_or(0);  // at first the file does not exist
    const std::uint64_t more = bytes - std::min(bytes, drawn_);
    drawn_ += more;
    return Ledger::draw_write(more);
  }

 private:
  const fs::path& path_;
  std::uint64_t drawn_ = 0;
};

int CPL_STDCALL tell(double done, const char*, void* to) {
  return (*static_cast<const std::function<bool(double)>*>(to))(done) ? 1 : 0;
}

}  // namespace

CogFile::CogFile(const GdalLibrary& gdal, const fs::path& target, const Grid& grid, const CogOptions& options)
    : gdal_(gdal),
      target_(target),
      grid_(grid),
      options_(options),
      raw_(temporary_name(target).string() + ".raw"),
      shade_(temporary_name(target).string() + ".shade"),
      cog_(temporary_name(target)),
      cache_(gdal, options.cache_bytes),
      written_(static_cast<std::size_t>(((grid.width + block_side - 1) / block_side) *
                                        ((grid.height + block_side - 1) / block_side))),
      old_(block_side * block_side) {}

CogFile::~CogFile() {
  const GdalQuiet quiet(gdal_);
  if (dataset_ != nullptr) gdal_.GDALClose(dataset_);
}

Error CogFile::refused(const GdalQuiet& quiet) const {
  return error(Errc::io, target_.string() + ": cannot be written: " + quiet.message());
}

Result<std::unique_ptr<CogFile>> CogFile::create(const fs::path& target, const Grid& grid, const CogOptions& options) {
  BOOST_OUTCOME_TRY(gdal, gdal_library());
  auto file = std::unique_ptr<CogFile>(new CogFile(*gdal, target, grid, options));
  BOOST_OUTCOME_TRYV(file->create_raw());
  return file;
}

Status CogFile::create_raw() {
  const GdalQuiet quiet(gdal_);
  const GDALDriverH driver = gdal_.GDALGetDriverByName("GTiff");
  if (driver == nullptr || gdal_.GDALGetDriverByName("COG") == nullptr)
    return error(Errc::io, "this GDAL cannot write cloud optimized GeoTIFFs");
  const std::string side = std::to_string(block_side);
  // Blocks that are never written take no room.
  Choices choices({"TILED=YES", "BLOCKXSIZE=" + side, "BLOCKYSIZE=" + side, "SPARSE_OK=TRUE", "BIGTIFF=IF_SAFER"});
  dataset_ =
      gdal_.GDALCreate(driver, raw_.path().c_str(), static_cast<int>(grid_.width), static_cast<int>(grid_.height), 1,
                       options_.doubles ? GDT_Float64 : GDT_Float32, choices.get());
  if (dataset_ == nullptr) return refused(quiet);
  double transform[] = {grid_.left(), grid_.res, 0, grid_.top(), 0, -grid_.res};
  const GDALRasterBandH band = gdal_.GDALGetRasterBand(dataset_, 1);
  if (gdal_.GDALSetGeoTransform(dataset_, transform) != CE_None ||
      gdal_.GDALSetRasterNoDataValue(band, std::numeric_limits<double>::quiet_NaN()) != CE_None)
    return refused(quiet);
  gdal_.GDALSetDescription(band, options_.name.c_str());
  if (options_.crs.empty()) return success();
  BOOST_OUTCOME_TRY(reference, SpatialReference::parse(gdal_, options_.crs));
  if (!options_.heights) gdal_.OSRStripVertical(reference.get());
  if (gdal_.GDALSetSpatialRef(dataset_, reference.get()) != CE_None) return refused(quiet);
  return success();
}

Status CogFile::add(Blocks& blocks) {
  Status status = success();
  blocks.take([&](std::int64_t x, std::int64_t y, Block& block) {
    if (status) status = add_block(x, y, block);
  });
  return status;
}

Status CogFile::add_block(std::int64_t x, std::int64_t y, Block& block) {
  const std::lock_guard lock(mutex_);
  const GdalQuiet quiet(gdal_);
  const auto width = std::min(block_side, grid_.width - x), height = std::min(block_side, grid_.height - y);
  const GDALRasterBandH band = gdal_.GDALGetRasterBand(dataset_, 1);
  const auto transfer = [&](GDALRWFlag way, double* pixels) {
    return gdal_.GDALRasterIO(band, way, static_cast<int>(x), static_cast<int>(y), static_cast<int>(width),
                              static_cast<int>(height), pixels, static_cast<int>(width), static_cast<int>(height),
                              GDT_Float64, 0, static_cast<int>(block_side * sizeof(double))) == CE_None;
  };
  const std::int64_t across = (grid_.width + block_side - 1) / block_side;
  const auto number = static_cast<std::size_t>(y / block_side * across + x / block_side);
  if (written_[number]) {
    if (!transfer(GF_Read, old_.data())) return refused(quiet);
    for (std::int64_t line = 0; line < height; ++line) {
      for (std::int64_t i = line * block_side; i < line * block_side + width; ++i) {
        const double old = old_[static_cast<std::size_t>(i)];
        if (std::isnan(old)) continue;
        if (!std::isnan(block.pixels[i])) return error(Errc::corrupt, "cells of different tiles overlap");
        block.pixels[i] = old;
      }
    }
  }
  if (!written_[number]) {
    BOOST_OUTCOME_TRYV(Ledger::draw_write(static_cast<std::uint64_t>(width * height) * (options_.doubles ? 8 : 4)));
  }
  written_[number] = true;
  pixels_ += block.drawn;
  if (!transfer(GF_Write, block.pixels)) return refused(quiet);
  return success();
}

Status CogFile::shade(const std::function<bool(double)>& go_on) {
  const GdalQuiet quiet(gdal_);
  const std::string side = std::to_string(block_side);
  std::vector<std::string> words = hillshade_words(*options_.light);
  words.insert(words.end(), {"-of", "GTiff", "-co", "TILED=YES", "-co", "BLOCKXSIZE=" + side, "-co",
                             "BLOCKYSIZE=" + side, "-co", "SPARSE_OK=TRUE", "-co", "BIGTIFF=IF_SAFER"});
  Choices choices(std::move(words));
  GDALDEMProcessingOptions* options = gdal_.GDALDEMProcessingOptionsNew(choices.get(), nullptr);
  if (options == nullptr) return refused(quiet);
  bool stopped = false;
  Growing growing(shade_.path());
  const std::function<bool(double)> ask = [&](double done) {
    stopped = stopped || !go_on(done) || !growing.draw();
    return !stopped;
  };
  gdal_.GDALDEMProcessingOptionsSetProgress(options, tell, const_cast<std::function<bool(double)>*>(&ask));
  const GDALDatasetH shaded =
      gdal_.GDALDEMProcessing(shade_.path().c_str(), dataset_, "hillshade", nullptr, options, nullptr);
  gdal_.GDALDEMProcessingOptionsFree(options);
  if (stopped || shaded == nullptr) {
    if (shaded != nullptr) gdal_.GDALClose(shaded);
    return stopped ? error(Errc::interrupted, "interrupted while shading the raster") : refused(quiet);
  }
  gdal_.GDALClose(dataset_);
  dataset_ = shaded;
  gdal_.GDALSetDescription(gdal_.GDALGetRasterBand(dataset_, 1), "hillshade");
  gdal_.GDALFlushCache(dataset_);
  if (gdal_.CPLGetLastErrorType() >= CE_Failure) return refused(quiet);
  return success();
}

Result<std::uint64_t> CogFile::finish(const std::function<bool(double)>& told) {
  const GdalQuiet quiet(gdal_);
  gdal_.GDALFlushCache(dataset_);
  if (gdal_.CPLGetLastErrorType() >= CE_Failure) return refused(quiet);
  const double shading_part = options_.light ? 0.5 : 0;
  if (options_.light) {
    BOOST_OUTCOME_TRYV(shade([&](double done) { return told(shading_part * done); }));
  }
  for (const auto& [name, value] : options_.metadata)
    if (gdal_.GDALSetMetadataItem(dataset_, name.c_str(), value.c_str(), nullptr) != CE_None) return refused(quiet);
  const auto go_on = [&](double done) { return told(shading_part + (1 - shading_part) * done); };
  // For 4 M pixels, GDAL's level 6 takes a third longer and makes the file 1 % smaller.
  Choices choices({"COMPRESS=DEFLATE", "LEVEL=1", "PREDICTOR=YES", "BIGTIFF=IF_SAFER", "OVERVIEWS=AUTO",
                   "OVERVIEW_RESAMPLING=AVERAGE", "NUM_THREADS=" + std::to_string(options_.threads)});
  bool stopped = false;
  Growing growing(cog_.path());
  const std::function<bool(double)> ask = [&](double done) {
    stopped = stopped || !go_on(done) || !growing.draw();
    return !stopped;
  };
  const GDALDatasetH cog = gdal_.GDALCreateCopy(gdal_.GDALGetDriverByName("COG"), cog_.path().c_str(), dataset_, 0,
                                                choices.get(), tell, const_cast<std::function<bool(double)>*>(&ask));
  if (cog != nullptr) gdal_.GDALClose(cog);  // only the message reports errors
  if (stopped) return error(Errc::interrupted, "interrupted while writing the raster");
  if (cog == nullptr || gdal_.CPLGetLastErrorType() >= CE_Failure) return refused(quiet);
  BOOST_OUTCOME_TRYV(growing.draw());
  BOOST_OUTCOME_TRY(bytes, file_bytes(cog_.path()));
  BOOST_OUTCOME_TRYV(publish(cog_.path(), target_));
  cog_.keep();
  BOOST_OUTCOME_TRYV(sync_folder(target_.has_parent_path() ? target_.parent_path() : fs::path(".")));
  return bytes;
}

}  // namespace tessera::terrain

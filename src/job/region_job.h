// Makes a region of a cloud that is not triangulated, as a result folder of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/input/cloud/cloud_units.h"
#include "src/job/result_folder.h"
#include "src/result/region/region_shape.h"
#include "src/result/region/regions.h"
#include "src/result/store/tile_store.h"

namespace tessera {

struct RegionJobOptions {
  CloudOptions cloud;
  bool scan_files = false;  // read all files once, instead of trusting the boxes that they state
  Box box;                  // closed; in 2D without bounds on z
  RegionShape shape = {};   // the region within the box, if it is not the whole box
  // Checks whether the region can belong to points with this coordinate system and these bounds; null: no check.
  std::function<Status(const std::string& crs, const Bounds& points)> check_place = {};
  RegionLimits limits;
  bool neighbors = true;
  std::vector<std::string> command = {};  // for the manifest
};

// A cloud of files that can be asked for any number of regions.
struct RegionCloud {
  std::vector<Manifest::Input> inputs;
  std::vector<Attribute> schema;
  std::string crs, unit;
  std::vector<std::string> warnings;
  int dimension = 3;
  std::uint64_t points = 0;  // in all files, including points that filters drop
  std::unique_ptr<Regions> regions;
};

// Opens the files, as Cloud::open takes them, and finds out where each unit's points are. Errors: those of CloudUnits.
Result<RegionCloud> open_regions(const std::vector<std::string>& inputs, const RegionJobOptions& options,
                                 const std::stop_token& stop = {});

// What is told of a region that was written.
struct RegionSummary {
  std::string out;
  int dimension = 3;
  std::uint64_t vertices = 0, cells = 0;
  std::uint64_t final = 0;  // cells that are final
  bool complete = true;
  std::string needed;  // if not complete: what is needed, as a sentence
  RegionFigures figures;
  std::vector<std::string> warnings;
};

std::string region_text(const RegionSummary& summary);
std::string region_json(const RegionSummary& summary);  // one line, without line end

// Asks for options.box, and writes the cells into `folder`, which has been inspected. The result has one tile that owns
// all vertices, and its manifest says that it is a region. Errors: those of Regions::ask and of writing; usage when no
// cell meets the box. An old result stays until the new cells are known.
Result<RegionSummary> write_region(RegionCloud& cloud, const RegionJobOptions& options, ResultFolder& folder,
                                   const std::stop_token& stop);

}  // namespace tessera

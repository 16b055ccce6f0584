#include "src/job/job_options.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"

namespace tessera {

std::string options_key(const JobOptions& options) {
  nlohmann::ordered_json key{{"dimension", options.cloud.dimension},
                             {"partition", name_of(options.partition)},
                             {"max_points_per_tile", options.max_points_per_tile},
                             {"tiles", options.tiles},
                             {"skip_invalid", options.cloud.skip_invalid},
                             {"classes", options.cloud.classes},
                             {"attributes", options.cloud.attributes},
                             {"z", options.cloud.heights},
                             {"neighbors", options.neighbors}};
  if (options.store != StoreAs::by_size) key["store"] = name_of(options.store);
  if (!options.cloud.crs.empty()) key["crs"] = options.cloud.crs;
  if (options.cloud.keep != DuplicatePolicy::first) key["keep"] = name_of(options.cloud.keep);
  if (!options.cloud.scans.empty()) key["scans"] = options.cloud.scans;
  if (!options.cloud.particles.empty()) key["particles"] = options.cloud.particles;
  if (!options.cloud.hdu.empty()) key["hdu"] = options.cloud.hdu;
  if (const auto& cosmology = options.cloud.cosmology)
    key["cosmology"] =
        json_text(nlohmann::json(cosmology->hubble)) + " " + json_text(nlohmann::json(cosmology->matter));
  if (options.cloud.returns != Returns::all) key["returns"] = static_cast<int>(options.cloud.returns);
  if (!options.cloud.without.empty()) key["without"] = options.cloud.without;
  if (!options.cloud.columns.empty()) key["columns"] = options.cloud.columns;
  if (options.cloud.resolution > 0) key["resolution"] = options.cloud.resolution;
  if (options.cloud.periodic_files) key["periodic_files"] = options.cloud.snap;
  if (!options.cloud.periodic.empty() && !options.cloud.periodic_files) {
    std::string text;
    for (const double length : options.cloud.periodic) text += json_text(nlohmann::json(length)) + " ";
    key["periodic"] = text;
    key["periodic_snap"] = options.cloud.snap;
  }
  if (const auto& crop = options.cloud.crop) {
    // As text, because JSON has no infinity.
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
      text += json_text(nlohmann::json(crop->lo[axis])) + " " + json_text(nlohmann::json(crop->hi[axis])) + " ";
    }
    key["crop"] = text;
  }
  return json_text(key);
}

Result<Box> crop_box(std::span<const double> numbers, int dimension) {
  Box box;
  if (numbers.size() == 4) {
    box.lo.x = numbers[0];
    box.lo.y = numbers[1];
    box.hi.x = numbers[2];
    box.hi.y = numbers[3];
  } else if (numbers.size() == 6 && dimension == 3) {
    box.lo = {numbers[0], numbers[1], numbers[2]};
    box.hi = {numbers[3], numbers[4], numbers[5]};
  } else if (dimension == 3) {
    return error(Errc::usage, "is not xmin,ymin,xmax,ymax or xmin,ymin,zmin,xmax,ymax,zmax");
  } else {
    return error(Errc::usage, "is not xmin,ymin,xmax,ymax");
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (!(box.lo[axis] <= box.hi[axis])) {
      return error(Errc::usage, std::string("is an empty box: its lowest ") + "xyz"[axis] + " is above its highest");
    }
  }
  return box;
}

Result<Returns> parse_returns(std::string_view text) {
  if (text == "all") return Returns::all;
  if (text == "first") return Returns::first;
  if (text == "last") return Returns::last;
  if (text == "single") return Returns::single;
  return error(Errc::usage, "'" + std::string(text) + "' is not one of all, first, last and single");
}

Result<DuplicatePolicy> parse_kept_point(std::string_view text) {
  if (const auto keep = kept_point_of(text)) return *keep;
  return error(Errc::usage, "'" + std::string(text) + "' is not one of first, last, lowest and highest");
}

Result<StoreAs> parse_store_as(std::string_view text) {
  const auto found = std::find(store_as_names.begin(), store_as_names.end(), text);
  if (found != store_as_names.end()) return static_cast<StoreAs>(found - store_as_names.begin());
  return error(Errc::usage, "'" + std::string(text) + "' is not one of auto, cells and points");
}

Status check_flags(const std::vector<std::string>& names) {
  for (const auto& name : names) {
    if (std::find(point_flags.begin(), point_flags.end(), name) == point_flags.end())
      return error(Errc::usage, "'" + name + "' is not one of withheld, synthetic, overlap and key_point");
  }
  return success();
}

}  // namespace tessera

#include "src/job/job_options.h"

#include <nlohmann/json.hpp>

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
  if (!options.cloud.crs.empty()) key["crs"] = options.cloud.crs;
  if (options.cloud.returns != Returns::all) key["returns"] = static_cast<int>(options.cloud.returns);
  if (!options.cloud.without.empty()) key["without"] = options.cloud.without;
  if (options.cloud.resolution > 0) key["resolution"] = options.cloud.resolution;
  if (const auto& crop = options.cloud.crop) {
    // As text: JSON has no infinity.
    std::string text;
    for (int axis = 0; axis < 3; ++axis) {
      text += nlohmann::json(crop->lo[axis]).dump() + " " + nlohmann::json(crop->hi[axis]).dump() + " ";
    }
    key["crop"] = text;
  }
  return key.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace tessera

#include <nlohmann/json.hpp>

#include "src/result/verify/verify.h"

namespace tessera {

std::string to_json(const VerifyReport& report, const std::string& result) {
  using Json = nlohmann::ordered_json;
  const Json object{{"event", "verified"},
                    {"result", result},
                    {"cells", report.cells},
                    {"facets", report.facets},
                    {"hull_facets", report.hull_facets},
                    {"vertices", report.vertices},
                    {"passed", report.passed}};
  return object.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tessera

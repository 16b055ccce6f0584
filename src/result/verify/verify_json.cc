#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
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
  return json_text(object);
}

}  // namespace tessera

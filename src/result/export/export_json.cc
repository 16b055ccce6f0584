#include <nlohmann/json.hpp>

#include "src/base/json/json_text.h"
#include "src/result/export/export.h"

namespace tessera {

std::string to_json(const Exported& exported, const std::string& output) {
  using Json = nlohmann::ordered_json;
  Json object{{"event", "exported"},           {"output", output},
              {"vertices", exported.vertices}, {"cells", exported.cells},
              {"left_out", exported.left_out}, {"files", exported.files},
              {"bytes", exported.bytes},       {"note", exported.note}};
  if (exported.corner) object["corner"] = {exported.corner->x, exported.corner->y, exported.corner->z};
  return json_text(object);
}

}  // namespace tessera

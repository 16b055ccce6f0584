#include "src/front/apps/words.h"

namespace tessera::apps {

std::string flag_name(std::string_view key, std::string_view value) {
  const std::string name(key);
  if (value == "false") return "--no-" + name;
  if (value.empty() || value == "true") return "--" + name;
  return "--" + name + " " + std::string(value);
}

}  // namespace tessera::apps

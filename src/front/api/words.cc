#include "src/front/api/words.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tessera {
namespace {

// The keys with another name here. All others have the name of the command, with _ for -.
constexpr std::array<std::pair<std::string_view, std::string_view>, 6> names{{{"class", "classes"},
                                                                              {"dim", "dimension"},
                                                                              {"memory", "memory_bytes"},
                                                                              {"scan", "scans"},
                                                                              {"type", "doubles"},
                                                                              {"z", "heights"}}};

bool is_word(std::string_view value) {
  return value != "true" && value != "false" && value.find_first_not_of("0123456789.-") != std::string_view::npos;
}

}  // namespace

std::string member_name(std::string_view key, std::string_view value) {
  const auto found = std::find_if(names.begin(), names.end(), [&](const auto& name) { return name.first == key; });
  std::string name(found == names.end() ? key : found->second);
  std::replace(name.begin(), name.end(), '-', '_');
  if (value.empty()) return name;
  const std::string quote = is_word(value) ? "\"" : "";
  return name + "(" + quote + std::string(value) + quote + ")";
}

}  // namespace tessera

// Names of columns for SQLite and GDAL, which ignore the case of letters.
#pragma once

#include <cctype>
#include <set>
#include <string>

namespace tessera::exports {

// Returns the name, with a trailing `_` added as long as `taken` has it, apart from upper and lower case. Adds the name
// to `taken`, which is in lower case.
inline std::string field_name(std::string name, std::set<std::string>& taken) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  while (!taken.insert(lower(name)).second) name += '_';
  return name;
}

}  // namespace tessera::exports

// Names of a table's columns, of which SQLite and GDAL take some for the same.
#pragma once

#include <cctype>
#include <set>
#include <string>

namespace tessera::exports {

// The name, with a trailing `_` when it is taken but for upper and lower case; it is taken then. `taken`: in lower
// case.
inline std::string field_name(std::string name, std::set<std::string>& taken) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  while (!taken.insert(lower(name)).second) name += '_';
  return name;
}

}  // namespace tessera::exports

// Real point clouds that nobody on the project made: those of tests/data/clouds, which every clone has, and more in a
// folder beside the project, which few have. Tests run over the former, and over the latter where they are.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <ostream>
#include <string>
#include <vector>

namespace tessera::testing_io {

inline const std::filesystem::path clouds = TESSERA_TEST_DATA "/clouds", more_clouds = TESSERA_MORE_CLOUDS;

// A file as a parameter of tests, which bear its name.
struct RealCloud {
  std::filesystem::path folder;
  std::string name;
  std::filesystem::path path() const { return folder / name; }
  friend std::ostream& operator<<(std::ostream& out, const RealCloud& cloud) { return out << cloud.name; }
};

inline bool has_more_clouds() { return std::filesystem::is_directory(more_clouds); }

// Those of `bundled`, and those of `more` where that folder is.
inline std::vector<RealCloud> real_clouds(std::initializer_list<const char*> bundled,
                                          std::initializer_list<const char*> more) {
  std::vector<RealCloud> all;
  for (const char* name : bundled) all.push_back({clouds, name});
  if (has_more_clouds()) {
    for (const char* name : more) all.push_back({more_clouds, name});
  }
  return all;
}

}  // namespace tessera::testing_io

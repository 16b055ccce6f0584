// What results offer for maps: collections of features, and a raster of heights.
#pragma once

#include <array>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/service/questions/questions_backend.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

// Thread-safe.
class Collections {
 public:
  explicit Collections(ResultFolders& results) : results_(results) {}

  Reply<std::vector<FeatureCollection>> list();
  Reply<FeatureCollection> find(std::string_view id);
  Reply<std::array<double, 4>> map_extent(std::string_view name);

 private:
  struct Place {
    std::array<double, 4> extent{};  // west, south, east and north
    std::string storage_crs;
  };
  // The place of a result on the earth; nothing when it is unknown or cannot be computed.
  std::optional<Place> place_of(const ResultFolders::Held& held);
  Result<std::optional<FeatureCollection>> make(const std::string& name, const std::string& kind,
                                                const ResultFolders::Held& held);

  ResultFolders& results_;
  std::mutex mutex_;
  std::map<std::string, std::optional<Place>> places_;  // by the identity of the result
};

}  // namespace tessera::service

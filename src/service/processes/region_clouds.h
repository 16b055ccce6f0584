// Keeps clouds for regions. What was read of a cloud for one region is reused for the next, in any job.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <mutex>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/job/region_job.h"

namespace tessera::service {

// Thread-safe.
class RegionClouds {
 public:
  // `memory_bytes` bounds the points that are kept while no job uses them.
  explicit RegionClouds(std::uint64_t memory_bytes) : memory_bytes_(memory_bytes) {}

  struct Lent {
    std::string key;
    RegionCloud cloud;
  };
  // Returns the cloud of these files, and opens it if it is not kept. A cloud with other options, or with files that
  // have changed, is another cloud. The borrower has the cloud alone; a second borrower gets a copy of its own. A cloud
  // of objects has an empty key, and is not kept. Errors: those of open_regions().
  Result<Lent> lend(const std::vector<std::string>& files, const RegionJobOptions& options, const std::string& words,
                    const std::stop_token& stop);
  // Returns a cloud after it was used without error. Clouds that do not fit are dropped, the least recently used first.
  void give_back(Lent lent);

  std::uint64_t bytes() const;

 private:
  static constexpr std::size_t clouds_max = 4;

  const std::uint64_t memory_bytes_;
  mutable std::mutex mutex_;
  std::list<Lent> clouds_;  // the most recently used first
};

}  // namespace tessera::service

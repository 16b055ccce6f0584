// Clouds of which regions were asked. What was read of one for a region is there for the next, of whatever job.
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

namespace tessera {

// Safe from any thread.
class RegionClouds {
 public:
  // Bytes of points that are kept while nobody asks for regions.
  explicit RegionClouds(std::uint64_t memory_bytes) : memory_bytes_(memory_bytes) {}

  struct Lent {
    std::string key;
    RegionCloud cloud;
  };
  // The cloud of these files, opened now if it is not at hand: with other options, or files that were changed since, it
  // is another one. It is the borrower's alone; who asks meanwhile gets one of its own. Errors: of open_regions().
  Result<Lent> lend(const std::vector<std::string>& files, const RegionJobOptions& options, const std::string& words,
                    const std::stop_token& stop);
  // After it was asked without an error. What does not fit goes, that which was used longest ago first.
  void give_back(Lent lent);

  std::uint64_t bytes() const;

 private:
  static constexpr std::size_t clouds_max = 4;

  const std::uint64_t memory_bytes_;
  mutable std::mutex mutex_;
  std::list<Lent> clouds_;  // the last asked first
};

}  // namespace tessera

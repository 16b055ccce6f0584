#include "src/service/processes/region_clouds.h"

#include <algorithm>

#include "src/base/files/there.h"
#include "src/input/bytes/objects.h"

namespace tessera::service {
namespace {

// The current state of the file.
Result<std::string> state_of(const std::string& file) {
  BOOST_OUTCOME_TRY(found, look_at(file));
  if (!found) return file + "\nmissing\n";
  const struct stat& status = *found;
  std::string state = file;
  for (const std::int64_t part :
       {static_cast<std::int64_t>(status.st_dev), static_cast<std::int64_t>(status.st_ino),
        static_cast<std::int64_t>(status.st_size), static_cast<std::int64_t>(status.st_mtim.tv_sec),
        static_cast<std::int64_t>(status.st_mtim.tv_nsec)})
    state += '\n' + std::to_string(part);
  return state + '\n';
}

}  // namespace

Result<RegionClouds::Lent> RegionClouds::lend(const std::vector<std::string>& files, const RegionJobOptions& options,
                                              const std::string& words, const std::stop_token& stop) {
  // Objects may change without a sign, so clouds of them are not kept.
  if (std::any_of(files.begin(), files.end(), [](const auto& file) { return names_object(file); })) {
    BOOST_OUTCOME_TRY(cloud, open_regions(files, options, stop));
    return Lent{"", std::move(cloud)};
  }
  std::string key = words + '\n';
  for (const auto& file : files) {
    BOOST_OUTCOME_TRY(state, state_of(file));
    key += state;
  }
  {
    const std::lock_guard lock(mutex_);
    const auto known = std::find_if(clouds_.begin(), clouds_.end(), [&](const Lent& lent) { return lent.key == key; });
    if (known != clouds_.end()) {
      Lent lent = std::move(*known);
      clouds_.erase(known);
      return lent;
    }
  }
  BOOST_OUTCOME_TRY(cloud, open_regions(files, options, stop));
  return Lent{std::move(key), std::move(cloud)};
}

void RegionClouds::give_back(Lent lent) {
  if (lent.key.empty()) return;
  lent.cloud.regions->forget(memory_bytes_);
  std::list<Lent> gone;  // freed without the lock
  const std::lock_guard lock(mutex_);
  // A cloud that another job opened meanwhile has no more than this one.
  for (auto at = clouds_.begin(); at != clouds_.end();) {
    const auto next = std::next(at);
    if (at->key == lent.key) gone.splice(gone.end(), clouds_, at);
    at = next;
  }
  clouds_.push_front(std::move(lent));
  std::uint64_t bytes = 0;
  for (auto at = clouds_.begin(); at != clouds_.end();) {
    const auto next = std::next(at);
    const std::uint64_t room = memory_bytes_ - std::min(bytes, memory_bytes_);
    at->cloud.regions->forget(room);
    bytes += at->cloud.regions->loaded_bytes();
    if (static_cast<std::size_t>(std::distance(clouds_.begin(), at)) >= clouds_max)
      gone.splice(gone.end(), clouds_, at);
    at = next;
  }
}

std::uint64_t RegionClouds::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t bytes = 0;
  for (const auto& lent : clouds_) bytes += lent.cloud.regions->loaded_bytes();
  return bytes;
}

}  // namespace tessera::service

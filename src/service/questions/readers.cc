#include "src/service/questions/readers.h"

#include <algorithm>
#include <utility>

#include "src/service/beneath.h"

namespace tessera::service {

Result<std::shared_ptr<Reader>> Readers::open(std::string_view name) {
  // Without the lock, because this reads the disk.
  BOOST_OUTCOME_TRY(held, results_.hold(name));
  const std::string identity = held.identity;
  const auto known = [&]() -> std::shared_ptr<Reader> {
    const auto found = std::find_if(readers_.begin(), readers_.end(),
                                    [&](const auto& reader) { return reader->held.identity == identity; });
    if (found == readers_.end()) return nullptr;
    readers_.splice(readers_.begin(), readers_, found);
    return readers_.front();
  };
  {
    const std::lock_guard lock(mutex_);
    if (auto reader = known()) return reader;
  }
  BOOST_OUTCOME_TRY(stored, query::StoredTriangulation::open(
                                path_of(held.folder), {.memory_bytes = memory_bytes_ / readers_max, .parts = true}));
  auto made = std::make_shared<Reader>(
      Reader{std::string(name), std::move(held), std::move(stored), {}, std::make_unique<Reader::Hull>()});
  {
    const std::lock_guard lock(mutex_);
    if (auto reader = known()) return reader;  // another thread was faster
    readers_.push_front(made);
    if (readers_.size() > readers_max) readers_.pop_back();
  }
  // The result may have been removed, and closed, just before it was added to the list.
  const auto now = results_.hold(name);
  if (now && now.value().identity == identity) return made;
  made->gone.request_stop();
  const std::lock_guard lock(mutex_);
  readers_.remove(made);
  return made;
}

void Readers::close(std::string_view name) {
  const std::lock_guard lock(mutex_);
  readers_.remove_if([&](const auto& reader) {
    if (reader->name != name) return false;
    reader->gone.request_stop();
    return true;
  });
}

std::size_t Readers::count() const {
  const std::lock_guard lock(mutex_);
  return readers_.size();
}

}  // namespace tessera::service

#include "src/service/questions/readers.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "src/base/files/names.h"
#include "src/service/beneath.h"

namespace tessera::service {

Result<std::shared_ptr<Reader>> Readers::open(std::string_view name, std::uint32_t version) {
  constexpr int tries_max = 100;
  for (int i = 0; i < tries_max; ++i) {
    // Without the lock, because this reads the disk.
    BOOST_OUTCOME_TRY(held, results_.hold(name, version));
    const std::string identity = held.identity;
    if (auto reader = known(identity)) return reader;
    auto opened = make(name, version, std::move(held));
    const auto now = results_.hold(name, version);
    const bool same = now && now.value().identity == identity;
    if (!opened && (same || !now)) return opened.error();
    if (!opened) continue;
    const auto& made = opened.value();
    if (same) return made;
    // The result has got a new version meanwhile, and nobody knows which one was opened. Or it was removed, and closed,
    // just before it was added to the list.
    if (!now) made->gone.request_stop();
    {
      const std::lock_guard lock(mutex_);
      readers_.remove(made);
    }
    if (!now) return made;
  }
  return error(Errc::io, "triangulation '" + std::string(name) +
                             "': is changed again and again, so that it cannot be opened; try again later");
}

std::shared_ptr<Reader> Readers::known(const std::string& identity) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(readers_.begin(), readers_.end(),
                                  [&](const auto& reader) { return reader->held.identity == identity; });
  if (found == readers_.end()) return nullptr;
  readers_.splice(readers_.begin(), readers_, found);
  return readers_.front();
}

Result<std::shared_ptr<Reader>> Readers::make(std::string_view name, std::uint32_t version, ResultFolders::Held held) {
  const std::filesystem::path out = path_of(held.folder);
  BOOST_OUTCOME_TRY(stored,
                    query::StoredTriangulation::open(version == 0 ? out : version_file(out, version),
                                                     {.memory_bytes = memory_bytes_ / readers_max, .parts = true}));
  auto made = std::make_shared<Reader>(
      Reader{std::string(name), version, std::move(held), std::move(stored), {}, std::make_unique<Reader::Hull>()});
  add(made);
  return made;
}

// Running questions keep a reader of an older version that leaves the list. Its files can then be removed.
void Readers::add(const std::shared_ptr<Reader>& made) {
  const std::lock_guard lock(mutex_);
  readers_.remove_if([&](const auto& reader) {
    return reader->held.identity == made->held.identity ||
           (made->version == 0 && reader->version == 0 && reader->name == made->name);
  });
  readers_.push_front(made);
  if (readers_.size() > readers_max) readers_.pop_back();
}

void Readers::close(std::string_view name) {
  const std::lock_guard lock(mutex_);
  readers_.remove_if([&](const auto& reader) {
    if (reader->name != name) return false;
    reader->gone.request_stop();
    return true;
  });
}

void Readers::renew(std::string_view name) {
  const std::lock_guard lock(mutex_);
  readers_.remove_if([&](const auto& reader) { return reader->name == name && reader->version == 0; });
}

std::size_t Readers::count() const {
  const std::lock_guard lock(mutex_);
  return readers_.size();
}

}  // namespace tessera::service

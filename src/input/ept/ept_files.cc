#include "src/input/ept/ept_files.h"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "src/base/on_threads.h"

namespace tessera::ept {
namespace {

// A kilobyte each.
constexpr std::size_t open_max = 8192;
// Most tiles and pages come with the first answer.
constexpr std::size_t first_bytes = std::size_t{256} << 10;

Result<std::shared_ptr<const ByteSource>> fetched(const FarSource& ept, const std::string& name) {
  BOOST_OUTCOME_TRY(file, ept.open_beside(name, first_bytes));
  const ByteRange all{0, file->size()};
  if (all.end <= near_bytes_max(*file)) {
    BOOST_OUTCOME_TRYV(bring_near(*file, std::span(&all, 1)));
  }
  return std::move(file);
}

}  // namespace

bool Files::knows(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return open_.contains(name);
}

Result<std::shared_ptr<const ByteSource>> Files::fetch(const FarSource& ept, const std::string& name) const {
  {
    std::unique_lock lock(mutex_);
    arrived_.wait(lock, [&] { return open_.contains(name) || !under_way_.contains(name); });
    if (const auto found = open_.find(name); found != open_.end()) return found->second;
    under_way_.insert(name);
  }
  struct Unmark {
    ~Unmark() {
      {
        const std::lock_guard lock(files.mutex_);
        files.under_way_.erase(name);
      }
      files.arrived_.notify_all();
    }
    const Files& files;
    const std::string& name;
  } const unmark{*this, name};
  BOOST_OUTCOME_TRY(file, fetched(ept, name));
  keep(name, file);
  return std::move(file);
}

void Files::keep(const std::string& name, std::shared_ptr<const ByteSource> file) const {
  const std::lock_guard lock(mutex_);
  if (!open_.emplace(name, std::move(file)).second) return;
  order_.push_back(name);
  if (order_.size() <= open_max) return;
  open_.erase(order_.front());
  order_.pop_front();
}

Result<std::unique_ptr<ByteSource>> Files::open(const ByteSource& ept, const std::filesystem::path& path) const {
  const auto* far = dynamic_cast<const FarSource*>(&ept);
  if (far == nullptr) return open_file(path);
  BOOST_OUTCOME_TRY(file, fetch(*far, path.string()));
  return share(std::move(file));
}

Status Files::bring(const ByteSource& ept, std::span<const std::filesystem::path> paths) const {
  const auto* far = dynamic_cast<const FarSource*>(&ept);
  if (far == nullptr) return success();
  std::vector<std::string> wanted;
  for (const auto& path : paths)
    if (!knows(path.string())) wanted.push_back(path.string());
  std::vector<std::optional<Error>> errors(wanted.size());
  std::atomic<std::size_t> next{0};
  std::atomic<bool> failed{false};
  const auto fetch_some = [&]() -> Status {
    for (std::size_t i = next++; i < wanted.size() && !failed; i = next++) {
      const auto file = fetch(*far, wanted[i]);
      if (file.has_value()) continue;
      errors[i] = file.error();
      failed = true;
    }
    return success();
  };
  const auto threads = static_cast<unsigned>(std::min(files_at_once, wanted.size()));
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, fetch_some));
  for (auto& error : errors)
    if (error) return *std::move(error);
  return success();
}

}  // namespace tessera::ept

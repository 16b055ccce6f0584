#include "src/input/remote/kept_pages.h"

#include <algorithm>
#include <utility>

#include "src/base/files/temporary.h"
#include "src/base/mixed_bits.h"

namespace tessera::remote {
namespace {

constexpr std::uint64_t least_bytes = std::uint64_t{64} << 20;

}  // namespace

std::size_t KeptPages::Hash::operator()(const PageKey& key) const {
  return static_cast<std::size_t>(mixed_bits(mixed_bits(key.object) + key.page));
}

KeptPages::KeptPages(std::filesystem::path folder, std::uint64_t bytes_max)
    : folder_(std::move(folder)), slots_max_(std::max(bytes_max, least_bytes) / page_bytes) {}

bool KeptPages::has(const PageKey& key) const {
  const std::lock_guard lock(mutex_);
  return slots_.contains(key);
}

Result<bool> KeptPages::read(const PageKey& key, std::uint64_t begin, std::span<std::byte> out) const {
  const std::lock_guard lock(mutex_);
  const auto slot = slots_.find(key);
  if (slot == slots_.end()) return false;
  BOOST_OUTCOME_TRY(got, read_up_to(file_.get(), out, slot->second * page_bytes + begin, folder_));
  if (got == out.size()) return true;
  return error(Errc::io, folder_.string() + ": bytes of an object that were kept there cannot be read back");
}

Status KeptPages::put(const PageKey& key, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  if (slots_.contains(key)) return success();
  if (file_.get() < 0) {
    BOOST_OUTCOME_TRY(place, folder_for_temporary(folder_));
    BOOST_OUTCOME_TRY(file, nameless_file(place));
    folder_ = std::move(place);
    file_ = std::move(file);
  }
  BOOST_OUTCOME_TRYV(
      write_at(file_.get(), bytes, next_ * page_bytes, folder_, "cannot keep there what was fetched from a server"));
  if (next_ == keys_.size()) {
    keys_.push_back(key);
  } else {
    slots_.erase(keys_[next_]);
    keys_[next_] = key;
  }
  slots_[key] = next_;
  next_ = (next_ + 1) % slots_max_;
  return success();
}

}  // namespace tessera::remote

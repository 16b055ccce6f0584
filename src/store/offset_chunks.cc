#include "src/store/offset_chunks.h"

#include <zlib.h>

#include <cassert>
#include <map>
#include <mutex>
#include <utility>

namespace tessera::store {

namespace {

std::vector<std::byte> compress_chunk(std::uint64_t first, std::uint64_t count, int step) {
  std::vector<std::byte> shuffled(count * 4);
  for (std::uint64_t i = 0; i < count; ++i) {
    // A last chunk may reach beyond the array's end; what it holds there is never read and may wrap around.
    const auto value = static_cast<std::uint32_t>((first + i) * static_cast<std::uint64_t>(step));
    for (std::uint64_t byte = 0; byte < 4; ++byte)
      shuffled[byte * count + i] = static_cast<std::byte>(value >> (8 * byte));
  }
  uLongf size = compressBound(static_cast<uLong>(shuffled.size()));
  std::vector<std::byte> packed(size);
  [[maybe_unused]] const int result =
      compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(shuffled.data()),
                static_cast<uLong>(shuffled.size()), 1);
  assert(result == Z_OK);  // the buffer is as large as zlib asked for
  packed.resize(size);
  return packed;
}

}  // namespace

std::shared_ptr<const std::vector<std::byte>> offsets_chunk(std::uint64_t first, std::uint64_t count, int step) {
  if (count != offsets_per_chunk)
    return std::make_shared<const std::vector<std::byte>>(compress_chunk(first, count, step));
  static std::mutex mutex;
  static std::map<std::pair<std::uint64_t, int>, std::shared_ptr<const std::vector<std::byte>>> chunks;
  const auto key = std::pair(first, step);
  {
    const std::lock_guard lock(mutex);
    if (const auto found = chunks.find(key); found != chunks.end()) return found->second;
  }
  // Made outside the lock: two threads may both make it, and one copy is dropped.
  auto made = std::make_shared<const std::vector<std::byte>>(compress_chunk(first, count, step));
  const std::lock_guard lock(mutex);
  return chunks.try_emplace(key, std::move(made)).first->second;
}

}  // namespace tessera::store

#include "src/input/e57/e57_pages.h"

#include <algorithm>
#include <boost/crc.hpp>
#include <cstring>
#include <string>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t checksum_bytes = 4;
constexpr std::size_t pages_at_once = 64;
constexpr std::size_t blocks_kept = 8;  // several fields are read from nearby places

// CRC-32C, with the highest byte first in the file.
std::uint32_t checksum_of(std::span<const std::byte> page) {
  boost::crc_optimal<32, 0x1EDC6F41, 0xFFFFFFFF, 0xFFFFFFFF, true, true> crc;
  crc.process_bytes(page.data(), page.size());
  return __builtin_bswap32(crc.checksum());
}

}  // namespace

E57Pages::E57Pages(std::unique_ptr<ByteSource> source, std::size_t page_bytes)
    : source_(std::move(source)), page_bytes_(page_bytes) {}

std::uint64_t E57Pages::logical(std::uint64_t physical) const {
  const std::uint64_t in_page = physical % page_bytes_;
  return physical / page_bytes_ * (page_bytes_ - checksum_bytes) +
         std::min<std::uint64_t>(in_page, page_bytes_ - checksum_bytes);
}

std::uint64_t E57Pages::size() const { return source_->size() / page_bytes_ * (page_bytes_ - checksum_bytes); }

Result<const E57Pages::Block*> E57Pages::block(std::uint64_t number) {
  const auto known = std::find_if(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.number == number; });
  if (known != blocks_.end()) {
    blocks_.splice(blocks_.begin(), blocks_, known);
    return &blocks_.front();
  }
  const std::uint64_t pages = source_->size() / page_bytes_, first = number * pages_at_once;
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(pages_at_once, pages - first));
  std::vector<std::byte> stored(n * page_bytes_);
  BOOST_OUTCOME_TRYV(source_->read(first * page_bytes_, stored));
  const std::size_t content = page_bytes_ - checksum_bytes;
  Block read{.number = number, .bytes = std::vector<std::byte>(n * content)};
  for (std::size_t i = 0; i < n; ++i) {
    const auto page = std::span(stored).subspan(i * page_bytes_, content);
    std::uint32_t checksum = 0;
    std::memcpy(&checksum, stored.data() + i * page_bytes_ + content, sizeof checksum);
    if (checksum != checksum_of(page))
      return error(Errc::bad_input, source_->path().string() + ", page " + std::to_string(first + i) +
                                        ": is damaged: its checksum does not match its content");
    std::memcpy(read.bytes.data() + i * content, page.data(), content);
  }
  if (blocks_.size() == blocks_kept) blocks_.pop_back();
  blocks_.push_front(std::move(read));
  return &blocks_.front();
}

Status E57Pages::read(std::uint64_t at, std::span<std::byte> out) {
  if (at > size() || out.size() > size() - at)
    return error(Errc::bad_input, source_->path().string() + ": refers to bytes behind its end");
  const std::uint64_t block_bytes = pages_at_once * (page_bytes_ - checksum_bytes);
  while (!out.empty()) {
    BOOST_OUTCOME_TRY(there, block(at / block_bytes));
    const auto from = static_cast<std::size_t>(at % block_bytes);
    const std::size_t n = std::min(out.size(), there->bytes.size() - from);
    std::memcpy(out.data(), there->bytes.data() + from, n);
    out = out.subspan(n);
    at += n;
  }
  return success();
}

}  // namespace tessera

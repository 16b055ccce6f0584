#include "src/base/files/checksum.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstdio>
#include <memory>
#include <utility>
#include <vector>

#include "src/base/files/disk_file.h"

namespace tessera {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

std::uint64_t record_checksum(std::span<const std::byte> records, std::size_t record_bytes, std::uint64_t first) {
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at < records.size(); at += record_bytes)
    sum += XXH3_64bits_withSeed(records.data() + at, record_bytes, first++);
  return sum;
}

namespace {

Result<std::uint64_t> checksum_pieces(DiskFile file) {
  std::vector<std::byte> piece(sum_piece_bytes);
  std::vector<std::uint64_t> sums;
  for (;;) {
    BOOST_OUTCOME_TRY(n, file.read(piece));
    if (n > 0) sums.push_back(checksum(std::span(piece).first(n)));
    if (n < piece.size()) break;
  }
  return checksum(std::as_bytes(std::span(sums)));
}

}  // namespace

Result<std::uint64_t> checksum_file(const std::filesystem::path& path, ChecksumOf what) {
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  if (what == ChecksumOf::pieces) return checksum_pieces(std::move(file));
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state(XXH3_createState(), &XXH3_freeState);
  XXH3_64bits_reset(state.get());
  std::vector<std::byte> buffer(std::size_t{1} << 18);  // small enough to stay in the second-level cache
  for (;;) {
    BOOST_OUTCOME_TRY(n, file.read(buffer));
    XXH3_64bits_update(state.get(), buffer.data(), n);
    if (n < buffer.size()) break;
  }
  return XXH3_64bits_digest(state.get());
}

std::string checksum_text(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

}  // namespace tessera

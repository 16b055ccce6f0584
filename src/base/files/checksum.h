// XXH3-64, as files are checksummed: against damage, not against malice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0);
// Of records of one size that are number `first`, `first` + 1, ... of a file: the sum of their checksums, each seeded
// with its number. So the sums of the parts of a file add up to the file's, however it was cut, and order counts.
// REQUIRES: records.size() is a multiple of record_bytes, which is not 0.
std::uint64_t record_checksum(std::span<const std::byte> records, std::size_t record_bytes, std::uint64_t first);
// What a file's checksum is made of: its bytes; or, so that it can be written in any order, the checksums of its
// pieces, of sum_piece_bytes but for the last one, 8 bytes each.
enum class SumOf : std::uint8_t { bytes, pieces };
inline constexpr std::size_t sum_piece_bytes = std::size_t{1} << 20;
// Of the whole file, streamed. Error io when it cannot be read.
Result<std::uint64_t> checksum_file(const std::filesystem::path& path, SumOf what = SumOf::bytes);
// 16 lower-case hexadecimal digits, as in the manifest.
std::string checksum_text(std::uint64_t value);

}  // namespace tessera

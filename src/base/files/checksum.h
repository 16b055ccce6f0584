// Checksums of files: XXH3-64. They protect against damage, not against malice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "src/base/result.h"

namespace tessera {

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0);
// The checksum of records of one size with the numbers `first`, `first` + 1, ... in a file: the sum of the records'
// checksums, each seeded with the record's number. So the sums of a file's parts add up to the file's sum, however the
// file was cut, and the order of records counts.
// REQUIRES: records.size() is a multiple of record_bytes, which is not 0.
std::uint64_t record_checksum(std::span<const std::byte> records, std::size_t record_bytes, std::uint64_t first);
// What a file's checksum is made of: the file's bytes, or the checksums of its pieces, 8 bytes each. A piece has
// sum_piece_bytes; the last one may have less. With pieces a file can be written in any order.
enum class ChecksumOf : std::uint8_t { bytes, pieces };
inline constexpr std::size_t sum_piece_bytes = std::size_t{1} << 20;
// The checksum of a whole file, which is streamed. Error io when the file cannot be read.
Result<std::uint64_t> checksum_file(const std::filesystem::path& path, ChecksumOf what = ChecksumOf::bytes);
// 16 lower-case hexadecimal digits, as in the manifest.
std::string checksum_text(std::uint64_t value);

}  // namespace tessera

// Headers of FITS files. Source: the FITS standard 4.0, section 4 (https://fits.gsfc.nasa.gov/fits_standard.html).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace tessera {

// Headers and data fill whole blocks: headers with spaces, data with zeros.
inline constexpr std::size_t fits_block_bytes = 2880;
constexpr std::uint64_t fits_blocks_of(std::uint64_t bytes) {
  return (bytes + fits_block_bytes - 1) / fits_block_bytes * fits_block_bytes;
}

// Lines of 80 characters, each with a keyword of at most 8 characters and a value.
class FitsCards {
 public:
  void flag(std::string_view key, bool value) { add(key, value ? "T" : "F"); }
  void whole(std::string_view key, std::uint64_t value) { add(key, std::to_string(value)); }
  void whole(std::string_view key, int value) { add(key, std::to_string(value)); }
  // The shortest number that is read as the same double. REQUIRES: the number is finite.
  void real(std::string_view key, double value);
  // A text has printable ASCII characters; others become `_`. At most 68 characters are kept.
  void text(std::string_view key, std::string_view value);
  // A text without a keyword, in as many lines as it needs.
  void comment(std::string_view text);
  // A value as it stands in the file.
  void add(std::string_view key, std::string_view value);
  // Ends the header, and fills its last block.
  std::string end();

 private:
  void line(std::string text);
  std::string text_;
};

}  // namespace tessera

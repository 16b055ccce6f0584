// The lines of a text file, without loading the file.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"

namespace tessera {

// Reads lines. A line ends with "\n" or "\r\n" or at the end of the file; a lone "\r" is a character. A line longer
// than 1 MiB is an error. The byte order mark that some programs put before UTF-8 belongs to no line.
class LineReader {
 public:
  explicit LineReader(std::unique_ptr<ByteSource> source, std::uint64_t offset = 0);

  // The next line without its end, valid until the next call. Nothing at the end of the file.
  Result<std::optional<std::string_view>> next();
  // The number of the line that next() returned last. The line at `offset` has number 1.
  std::uint64_t number() const { return number_; }
  // The offset in the source at which that line begins.
  std::uint64_t line_at() const { return line_at_; }
  // The offset in the source of the first byte behind that line.
  std::uint64_t next_at() const { return position_ - (end_ - begin_); }
  // Makes the first line the next line again.
  void rewind();
  const ByteSource& source() const { return *source_; }
  std::unique_ptr<ByteSource> take_source() { return std::move(source_); }  // this reader can no longer be used
  // The error "cloud.xyz, line 812: " + what, for the last line.
  Error bad_line(const std::string& what) const;
  // Makes the line at `offset` number lines_before + 1.
  void count_from(std::uint64_t lines_before) { number_ = first_number_ = lines_before; }

 private:
  Status fill();

  std::unique_ptr<ByteSource> source_;
  std::uint64_t start_;     // the offset of the first line
  std::uint64_t position_;  // the offset of the first byte that is not yet in block_
  std::vector<char> block_;
  std::size_t begin_ = 0, end_ = 0;  // the part of block_ that is not yet returned
  std::uint64_t number_ = 0, first_number_ = 0, line_at_ = 0;
};

// Error bad_input if there are zero bytes at the beginning, because text has none.
Status check_is_text(const ByteSource& source);

}  // namespace tessera

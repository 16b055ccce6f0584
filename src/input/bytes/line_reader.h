// Lines of a text file, without loading the file.
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

// Lines end with "\n" or "\r\n" (or the file's end); a lone "\r" is a character. A line longer than 1 MiB is an error.
// The byte order mark that some programs put before UTF-8 belongs to no line.
class LineReader {
 public:
  explicit LineReader(std::unique_ptr<ByteSource> source, std::uint64_t offset = 0);

  // The next line without its end, valid until the next call; nothing at the end of the file.
  Result<std::optional<std::string_view>> next();
  // Number of the line next() returned last, from 1 for the one at `offset`.
  std::uint64_t number() const { return number_; }
  // Where in the source that line begins.
  std::uint64_t line_at() const { return line_at_; }
  // Starts again at the first line.
  void rewind();
  const ByteSource& source() const { return *source_; }
  std::unique_ptr<ByteSource> take_source() { return std::move(source_); }  // the end of this reader
  // "cloud.xyz, line 812: " + what.
  Error bad_line(const std::string& what) const;
  // Makes the line at `offset` number lines_before + 1.
  void count_from(std::uint64_t lines_before) { number_ = first_number_ = lines_before; }

 private:
  Status fill();

  std::unique_ptr<ByteSource> source_;
  std::uint64_t start_;     // of the first line
  std::uint64_t position_;  // of the first byte not yet in block_
  std::vector<char> block_;
  std::size_t begin_ = 0, end_ = 0;  // what of block_ is not yet returned
  std::uint64_t number_ = 0, first_number_ = 0, line_at_ = 0;
};

// Error bad_input if there are zero bytes at the begin, where no text has any.
Status check_is_text(const ByteSource& source);

}  // namespace tessera

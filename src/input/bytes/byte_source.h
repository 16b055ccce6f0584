// Where a reader's bytes come from: a file, what a compressed file or standard input was written to, or memory in
// tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// Random access to `size()` bytes that must not change while they are read.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual const std::filesystem::path& path() const = 0;
  virtual std::uint64_t size() const = 0;        // when it was opened
  virtual std::int64_t modified_ns() const = 0;  // since 1970, when it was opened
  // Of a compressed file the three above speak of what is in it (size) and of itself (path, modified_ns). Then:
  virtual std::uint64_t stored_bytes() const { return size(); }          // its own size
  virtual std::string packing() const { return ""; }                     // "gzip" or "zstd"
  virtual std::filesystem::path content_name() const { return path(); }  // "a.xyz" of a.xyz.gz; empty: nobody knows
  // Fills `out` with the bytes from `offset` on. Error bad_input if the file has become shorter than that, io if the
  // system refuses. REQUIRES: offset + out.size() <= size().
  virtual Status read(std::uint64_t offset, std::span<std::byte> out) const = 0;
  // Error bad_input if size or modification time are no longer those of the opening. Readers call it at the end, so
  // that a file rewritten meanwhile does not pass for a cloud that never was.
  virtual Status check_unchanged() const = 0;
};

// Errors: missing, unreadable (io), a directory, not a regular file (bad_input).
Result<std::unique_ptr<ByteSource>> open_file(const std::filesystem::path& path);

// What the open descriptor `file` gives from its begin; it is closed at the end, also on error. Errors as above.
Result<std::unique_ptr<ByteSource>> open_descriptor(const std::filesystem::path& path, int file,
                                                    const std::filesystem::path& content_name);

// ByteSource::read for an open descriptor; errors name `path`.
Status read_at(int file, std::uint64_t offset, std::span<std::byte> out, const std::filesystem::path& path);

// A source that several readers share.
std::unique_ptr<ByteSource> share(std::shared_ptr<const ByteSource> source);

std::unique_ptr<ByteSource> memory_source(std::filesystem::path name, std::vector<std::byte> bytes);

}  // namespace tessera

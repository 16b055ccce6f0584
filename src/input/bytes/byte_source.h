// The bytes that a reader reads: a file, the unpacked content of a compressed file or of standard input, or memory.
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

// Random access to size() bytes, which must not change while they are read. Const functions are thread-safe.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  virtual const std::filesystem::path& path() const = 0;
  virtual std::uint64_t size() const = 0;        // in bytes, when the source was opened
  virtual std::int64_t modified_ns() const = 0;  // nanoseconds since 1970, when the source was opened
  // For a compressed file size() is that of the content; path() and modified_ns() are those of the file. The next
  // three:
  virtual std::uint64_t stored_bytes() const { return size(); }          // the size of the compressed file
  virtual std::string packing() const { return ""; }                     // "gzip" or "zstd"; "" if not compressed
  virtual std::filesystem::path content_name() const { return path(); }  // "a.xyz" for a.xyz.gz; empty if unknown
  // Fills `out` with the bytes from `offset` on. Errors: bad_input if the file has become shorter than that; io if the
  // system refuses. REQUIRES: offset + out.size() <= size().
  virtual Status read(std::uint64_t offset, std::span<std::byte> out) const = 0;
  // Error bad_input if size or modification time have changed since the opening. Readers call this at the end, so that
  // a file that was rewritten meanwhile is not taken for a valid cloud.
  virtual Status check_unchanged() const = 0;
};

// Opens a file. Errors: io for a missing or unreadable file; bad_input for a folder, or what is not a regular file.
Result<std::unique_ptr<ByteSource>> open_file(const std::filesystem::path& path);

// A source of what the open descriptor `file` gives from its beginning. The source closes the descriptor at its end,
// and the function closes it on error. Errors: as for open_file().
Result<std::unique_ptr<ByteSource>> open_descriptor(const std::filesystem::path& path, int file,
                                                    const std::filesystem::path& content_name);

// ByteSource::read() for an open descriptor. Errors name `path`.
Status read_at(int file, std::uint64_t offset, std::span<std::byte> out, const std::filesystem::path& path);

// A source over another source that several readers share.
std::unique_ptr<ByteSource> share(std::shared_ptr<const ByteSource> source);

// A source of bytes in memory, for tests.
std::unique_ptr<ByteSource> memory_source(std::filesystem::path name, std::vector<std::byte> bytes);

}  // namespace tessera

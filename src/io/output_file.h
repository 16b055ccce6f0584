// A file that is there whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

// Bytes go to "<path>.partial-<pid>", which commit() syncs and renames; without commit() the destructor removes it.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& path);
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

  // Errors io: a full disk, a quota, ...
  Status append(std::span<const std::byte> bytes);
  Status append(std::string_view text) { return append(std::as_bytes(std::span(text))); }
  // Replaces bytes appended before: the header, once the counts are known.
  Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes);
  Status commit();
  const std::filesystem::path& path() const { return path_; }

 private:
  OutputFile(std::filesystem::path path, std::filesystem::path partial, int file);
  Status flush();
  Status write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  Error refused(const std::string& what, int code) const;

  std::filesystem::path path_, partial_;
  int file_ = -1;
  std::uint64_t flushed_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace tessera

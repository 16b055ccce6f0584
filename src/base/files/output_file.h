// Buffered output to a file that appears whole or not at all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/result.h"

namespace tessera {

// Bytes go to a temporary name of this process. commit() syncs the file and renames it. Without commit() the destructor
// removes the file.
class OutputFile {
 public:
  static Result<OutputFile> create(const std::filesystem::path& path);

  // Error io: a full disk, a quota, ...; or the error of the thread's ledger.
  Status append(std::span<const std::byte> bytes);
  Status append(std::string_view text) { return append(std::as_bytes(std::span(text))); }
  // Replaces bytes that were appended before, such as a header once the counts are known.
  Status overwrite(std::uint64_t offset, std::span<const std::byte> bytes);
  Status commit();
  const std::filesystem::path& path() const { return path_; }

 private:
  OutputFile(std::filesystem::path path, TemporaryFile temporary, FileHandle file);
  Status flush();

  std::filesystem::path path_;
  TemporaryFile temporary_;
  FileHandle file_;
  std::uint64_t flushed_ = 0;
  std::vector<std::byte> buffer_;
};

}  // namespace tessera

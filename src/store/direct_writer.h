// Writes one new file from its beginning to its end past the page cache: a result is written once and not read again
// soon, and fresh pages for it cost more than the disk does (docs/benchmarks.md). Tells size and checksum on the way.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>

#include "src/base/result.h"
#include "src/files/descriptor.h"
#include "src/store/block_sum.h"

struct XXH3_state_s;

namespace tessera::store {

class DirectWriter {
 public:
  // Error messages name `final_name`, which `path` is a temporary name of.
  // Whoever appends soon gets the exception Stopped once `stop` is requested.
  static Result<DirectWriter> create(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                     std::stop_token stop = {});

  Status append(std::span<const std::byte> bytes);
  // The same, and adds them to `sum` on the way.
  Status append(std::span<const std::byte> bytes, BlockSum& sum);

  struct Written {
    std::uint64_t bytes = 0;
    std::uint64_t xxh3 = 0;  // XXH3-64 of the whole file
  };
  // Writes what is left and closes the file.
  Result<Written> finish();

 private:
  struct FreeState {
    void operator()(XXH3_state_s* state) const;
  };
  struct FreeBlock {
    void operator()(std::byte* block) const { std::free(block); }
  };
  DirectWriter(FileHandle file, std::filesystem::path final_name, bool direct, std::stop_token stop);
  template <class Copy>
  Status append_by(std::span<const std::byte> bytes, const Copy& copy);
  Status flush();
  void hash_filled();
  bool leave_direct();

  FileHandle file_;
  std::filesystem::path final_name_;
  bool direct_;
  std::stop_token stop_;
  std::unique_ptr<XXH3_state_s, FreeState> hash_;
  std::unique_ptr<std::byte[], FreeBlock> block_;
  std::size_t filled_ = 0, hashed_ = 0;
  std::uint64_t offset_ = 0;  // of block_ in the file
};

}  // namespace tessera::store

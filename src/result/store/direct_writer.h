// Writes a file past the page cache. A result is written once and not read again soon, and fresh pages for it cost more
// than the disk does (docs/benchmarks.md). Bytes are appended from the beginning to the end, but gaps may be left,
// which another writer fills later. Computes the size and the checksum on the way.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/block_sum.h"

struct XXH3_state_s;

namespace tessera::store {

class DirectWriter {
 public:
  // The state of an unfinished file: its bytes, and the checksum of each of its pieces.
  struct Begun {
    std::uint64_t bytes = 0;
    std::vector<std::uint64_t> sums;
  };
  // create() begins a new file; go_on() continues a file that pause() has left. `path` is a temporary name; error
  // messages have `final_name`. After `stop` is requested, append() soon throws Stopped.
  static Result<DirectWriter> create(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                     std::stop_token stop = {});
  static Result<DirectWriter> go_on(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                    Begun begun, std::stop_token stop = {});

  Status append(std::span<const std::byte> bytes);
  // Appends, and adds the bytes to `sum` on the way.
  Status append(std::span<const std::byte> bytes, BlockChecksum& sum);
  // Sets the offset of the next append(). Bytes that are passed over keep their values; in a new file they are zeros.
  // Error corrupt when `offset` lies before the end of what was appended.
  Status skip_to(std::uint64_t offset);

  // pause() and finish() write what is left and close the file.
  Result<Begun> pause();
  struct Written {
    std::uint64_t bytes = 0;
    std::uint64_t xxh3 = 0;  // checksum_file() with ChecksumOf::pieces
  };
  // Error corrupt when the file had more bytes than have been appended.
  Result<Written> finish();

 private:
  struct FreeState {
    void operator()(XXH3_state_s* state) const;
  };
  struct FreePiece {
    void operator()(std::byte* piece) const { std::free(piece); }
  };
  DirectWriter(FileHandle file, std::filesystem::path final_name, bool direct, std::stop_token stop);
  static Result<DirectWriter> open(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                   int flags, const char* what, std::stop_token stop);
  template <class Copy>
  Status append_by(std::span<const std::byte> bytes, const Copy& copy);
  Status begin_piece(std::uint64_t offset);
  Status write_piece();
  Status close();
  void hash_filled();
  void fill_up_to(std::size_t end);
  bool leave_direct();

  FileHandle file_;
  std::filesystem::path final_name_;
  bool direct_;
  std::stop_token stop_;
  Begun begun_;
  std::unique_ptr<XXH3_state_s, FreeState> hash_;  // state of the piece's checksum
  std::unique_ptr<std::byte[], FreePiece> piece_;
  std::uint64_t offset_ = 0;             // of the piece in the file
  std::size_t filled_ = 0, hashed_ = 0;  // bytes of the piece
  std::size_t known_ = 0;                // bytes of the piece that the file had before
};

}  // namespace tessera::store

// Writes a file past the page cache: a result is written once and not read again soon, and fresh pages for it cost more
// than the disk does (docs/benchmarks.md). From its beginning to its end, or with places left out that another writer
// fills later. Tells size and checksum on the way.
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
  // What is there of a file that is not finished: its bytes, and the checksum of each of its pieces.
  struct Begun {
    std::uint64_t bytes = 0;
    std::vector<std::uint64_t> sums;
  };
  // Writes a new file, or goes on with what pause() has left of it. Error messages name `final_name`, which `path` is a
  // temporary name of. Whoever appends soon gets the exception Stopped once `stop` is requested.
  static Result<DirectWriter> create(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                     std::stop_token stop = {});
  static Result<DirectWriter> go_on(const std::filesystem::path& path, const std::filesystem::path& final_name,
                                    Begun begun, std::stop_token stop = {});

  Status append(std::span<const std::byte> bytes);
  // The same, and adds them to `sum` on the way.
  Status append(std::span<const std::byte> bytes, BlockSum& sum);
  // What is appended next stands there. What is passed over is left as it was; in a new file it is zeros.
  // Error corrupt when it is before the last byte that was appended.
  Status skip_to(std::uint64_t offset);

  // Each writes what is left and closes the file.
  Result<Begun> pause();
  struct Written {
    std::uint64_t bytes = 0;
    std::uint64_t xxh3 = 0;  // checksum_file() of its pieces
  };
  // Error corrupt when more was there than has been appended.
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
  std::unique_ptr<XXH3_state_s, FreeState> hash_;  // of the piece
  std::unique_ptr<std::byte[], FreePiece> piece_;
  std::uint64_t offset_ = 0;             // of the piece in the file
  std::size_t filled_ = 0, hashed_ = 0;  // bytes of it
  std::size_t known_ = 0;                // bytes that stood there before, at most those of the piece
};

}  // namespace tessera::store

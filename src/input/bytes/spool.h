// A spool: bytes that cannot be read twice, or only from their beginning, are written to disk once and read from there
// like a file.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/input/bytes/byte_source.h"
#include "src/input/bytes/unpack.h"

namespace tessera {

// The files of a spool have no names. They are gone when their sources are, however the process ends. Several sources
// share a file, so ten thousand compressed inputs need only as many descriptors as there are threads that unpack.
// Thread-safe.
class Spool {
 public:
  // `folder`: empty for the system's temporary folder. Files are made only when they are needed. `bytes_max`: the bound
  // on all unpacked bytes together; 0: no bound but the disk.
  explicit Spool(std::filesystem::path folder, std::stop_token stop = {}, std::uint64_t bytes_max = 0);

  // Returns `source` itself, or if it is compressed a source of its content, with the same path, modification time and
  // stored size. Errors: bad_input for damaged streams, and for content of unknown format, which is found at once;
  // memory when bytes_max is reached; io when the folder has no room, with the number of bytes that were unpacked;
  // interrupted; those of the thread's ledger. After an error no file is left behind.
  Result<std::shared_ptr<const ByteSource>> unpacked(std::shared_ptr<const ByteSource> source);

  // Returns standard input, unpacked if it is compressed. If it is redirected from a file, the file is read in place.
  // Errors: those above; usage for a terminal; interrupted within a tenth of a second, however slowly bytes come.
  Result<std::shared_ptr<const ByteSource>> standard_input();

  const std::stop_token& stop() const { return stop_; }

 private:
  struct File;
  struct Origin;
  class Source;
  Result<std::shared_ptr<File>> take();
  Result<std::shared_ptr<const ByteSource>> keep(Origin origin, FileFormat packing, InputBuffer& in);

  std::filesystem::path folder_;
  std::stop_token stop_;
  std::uint64_t bytes_max_;
  std::atomic<std::uint64_t> bytes_{0};
  std::mutex mutex_;
  std::vector<std::shared_ptr<File>> idle_;
};

}  // namespace tessera

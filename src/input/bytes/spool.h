// Bytes that cannot be read twice, or only from their begin, are written to disk once and read from there like any
// file.
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

// Its files have no name and are gone with the sources in them, whatever becomes of the process. Several sources share
// a file, so that ten thousand compressed inputs need as many descriptors as threads unpack them. Safe to share by
// threads.
class Spool {
 public:
  // `folder`: empty for the system's temporary folder. Nothing is made before it is needed. `bytes_max`: of all that is
  // unpacked together; 0: what the disk has.
  explicit Spool(std::filesystem::path folder, std::stop_token stop = {}, std::uint64_t bytes_max = 0);

  // `source` itself, or what is in it if it is compressed: then a source that keeps its path, modification time and
  // stored size. Errors: bad_input for damaged streams and for contents of no format we know (found at once); io when
  // the folder has no room or bytes_max is reached, with how much was unpacked; interrupted, with nothing left behind.
  Result<std::shared_ptr<const ByteSource>> unpacked(std::shared_ptr<const ByteSource> source);

  // Standard input, unpacked if it is compressed. A file that it is redirected from is read in place. Errors: also a
  // terminal (usage); Errc::interrupted within a tenth of a second, however slowly it comes.
  Result<std::shared_ptr<const ByteSource>> standard_input();

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

// Files of a result in an object store, or behind HTTP. A manifest says how many bytes each file has, and its checksum.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/files/checksum.h"
#include "src/base/files/descriptor.h"
#include "src/base/result.h"
#include "src/result/store/data_file.h"
#include "src/result/store/tile_store.h"

namespace tessera::result {

// Whether the path is the name of an object in a store, as s3://bucket/folder, and not of a file.
bool is_far(const std::filesystem::path& path);
// Error usage when the result is far: it cannot be changed where it is.
Status refuse_far(const std::filesystem::path& out);

// What the manifest says of a file.
struct ToldFile {
  std::uint64_t bytes = 0;
  std::uint64_t xxh3 = 0;
  ChecksumOf sum = ChecksumOf::bytes;
};

// Reads the manifest of a far result. Errors: those of copy_object() and parse_manifest(); usage for an address with
// parameters, behind which no name of a file can stand; corrupt for more than 256 MiB.
Result<Manifest> read_far_manifest(const std::filesystem::path& out);
// The same as bytes.
Result<std::vector<std::byte>> read_far_text(const std::filesystem::path& out);

// Copies of whole files, in files without names in the system's temporary folder. The oldest are given up when there
// are more than 1 GiB or 128 files of them. Thread-safe.
class FarFiles {
 public:
  // The whole file, fetched if it is not here. The copy was compared with what the manifest says, so that a file of
  // another version of the result, or of another result at the same place, is an error. Errors: corrupt; those of
  // copy_object(); io of the temporary folder.
  Result<DataFile> whole(const std::filesystem::path& name, const ToldFile& told, const std::stop_token& stop);
  // The file as it is here, or ranges of the object. Of the object only the number of bytes is compared. Errors: those
  // of open_object(); corrupt.
  Result<DataFile> ranges(const std::filesystem::path& name, std::uint64_t bytes, const std::stop_token& stop);

 private:
  struct Copy {
    std::string name;
    std::uint64_t bytes = 0;
    std::shared_ptr<const FileHandle> file;
  };
  // Returns null when the file is not here. REQUIRES: the mutex is held.
  std::shared_ptr<const FileHandle> find(const std::string& name);
  // REQUIRES: the mutex is held.
  void keep(Copy copy);

  std::mutex mutex_;
  std::condition_variable_any arrived_;
  std::set<std::string> under_way_;
  std::list<Copy> copies_;  // the one that was used last is the last
  std::uint64_t bytes_ = 0;
};

}  // namespace tessera::result

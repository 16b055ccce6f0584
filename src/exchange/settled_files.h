// Keeps what settled tiles are built from. All tiles of a node are in one file, because making a file takes longer than
// filling it. When several nodes use a run folder, each node appends to a file of its own and reads the files of all
// nodes.
#pragma once

#include <cstddef>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "src/base/big_vector.h"
#include "src/base/ids.h"
#include "src/base/result.h"

namespace tessera {

// Thread-safe.
class SettledFiles {
 public:
  // `seal` is that of the run.
  SettledFiles(const std::filesystem::path& run, std::uint64_t seal, NodeId node);

  // Appends the bytes of a tile, and makes the folder if it is missing. REQUIRES: called once for each tile. Error io.
  Status append(TileId tile, std::span<const std::byte> bytes);
  // Returns whether append() was called for the tile, in this or another process. A record that stands behind damage is
  // not found. Error io.
  Result<bool> has(TileId tile);
  // Returns the bytes of a tile, or nothing when has() is false. Errors io, corrupt.
  Result<std::optional<BigVector<std::byte>>> read(TileId tile);
  // Returns when all that append() was given is on the disk. Error io.
  Status sync();
  // Removes the files of all nodes. Error io.
  Status clear();

 private:
  struct StoredFrame {
    std::filesystem::path file;
    std::uint64_t at = 0;
  };
  struct Index {
    std::unordered_map<TileId, StoredFrame> frames;
    std::uint64_t bytes = 0;  // size of all files when they were read
  };
  Result<std::optional<StoredFrame>> find(TileId tile);
  Result<Index> read_index() const;
  Result<std::uint64_t> bytes_there() const;

  std::filesystem::path folder_, own_;
  std::uint64_t seal_;
  std::mutex mutex_;
  bool appended_ = false;  // by this object
  // Made when it is first needed, and again when a tile is missing and the files have grown.
  std::optional<Index> index_;
};

}  // namespace tessera

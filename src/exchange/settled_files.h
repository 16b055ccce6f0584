// What settled tiles are built from, of all tiles of a node in one file: to make a file takes longer than to fill it.
// In a run folder that several nodes write to, each appends to a file of its own, and reads those of all.
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

// Safe to call from several threads.
class SettledFiles {
 public:
  // `seal`: of the run.
  SettledFiles(const std::filesystem::path& run, std::uint64_t seal, NodeId node);

  // Once for each tile; makes the folder. Error io.
  Status append(TileId tile, std::span<const std::byte> bytes);
  // Whether append() was called for the tile, in whichever process: not for one that stands behind damage. Error io.
  Result<bool> has(TileId tile);
  // Nothing when has() says no. Error io, corrupt.
  Result<std::optional<BigVector<std::byte>>> read(TileId tile);
  // What append() was given is on the disk. Error io.
  Status sync();
  // Removes what all nodes have written. Error io.
  Status clear();

 private:
  struct Place {
    std::filesystem::path file;
    std::uint64_t at = 0;
  };
  struct Index {
    std::unordered_map<TileId, Place> places;
    std::uint64_t bytes = 0;  // of the files as they were read
  };
  Result<std::optional<Place>> find(TileId tile);
  Result<Index> read_index() const;
  Result<std::uint64_t> bytes_there() const;

  std::filesystem::path folder_, own_;
  std::uint64_t seal_;
  std::mutex mutex_;
  bool appended_ = false;  // by this object
  // Made when it is asked for, and again when a tile is missing and the files have grown.
  std::optional<Index> index_;
};

}  // namespace tessera

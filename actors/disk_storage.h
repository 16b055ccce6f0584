// A tile's bytes in a run folder, its result in the store.
#pragma once

#include <filesystem>

#include "actors/tile_storage.h"

namespace tessera {

class DiskStorage final : public TileStorage {
 public:
  // `run` outlives this. Scratch files go under run.folder, results to `out`.
  DiskStorage(const RoutedRun& run, std::filesystem::path out, StoreOptions options);

  Result<LoadedTile> load_points(TileId tile) override;
  Status put(TileId tile, Scratch what, std::span<const std::byte> bytes, bool append) override;
  Result<std::vector<std::byte>> take(TileId tile, Scratch what) override;
  Result<TileEntry> store(TileId tile, TileMesh& mesh) override;

 private:
  std::filesystem::path scratch_file(TileId tile, Scratch what) const;
  Result<std::vector<std::byte>> gather_rows(const TileMesh& mesh) const;

  const RoutedRun& run_;
  std::filesystem::path out_;
  StoreOptions options_;
};

}  // namespace tessera

// A tile's bytes in a run folder, its result in the store.
#pragma once

#include <boost/asio/thread_pool.hpp>
#include <filesystem>

#include "actors/tile_storage.h"

namespace tessera {

class DiskStorage final : public TileStorage {
 public:
  // `run` outlives this. Scratch files go under run.folder, results to `out`. As many meshes are stored at a time as
  // there are `threads`, which wait for the disk while others work.
  DiskStorage(const RoutedRun& run, std::filesystem::path out, StoreOptions options, std::uint32_t threads);
  // Waits for what is being stored.
  ~DiskStorage() override;

  Result<LoadedTile> load_points(TileId tile) override;
  Status put(TileId tile, Scratch what, std::span<const std::byte> bytes, bool append) override;
  Result<std::vector<std::byte>> take(TileId tile, Scratch what) override;
  void store(TileId tile, TileMesh mesh, Stored done) override;

 private:
  std::filesystem::path scratch_file(TileId tile, Scratch what) const;
  Result<std::vector<std::byte>> gather_rows(const TileMesh& mesh) const;
  Result<TileEntry> write(TileId tile, const TileMesh& mesh) const;

  const RoutedRun& run_;
  std::filesystem::path out_;
  StoreOptions options_;
  boost::asio::thread_pool writers_;
};

}  // namespace tessera

// Delaunay tiles' points in a run folder, their results in the store.
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <semaphore>
#include <vector>

#include "src/delaunay/delaunay_store.h"
#include "src/exchange/writers.h"
#include "src/mesh/tile_mesh.h"
#include "src/store/tile_store.h"

namespace tessera {

class DiskStore final : public DelaunayStore {
 public:
  // Results go to `out`; error io before anything is written there when the lock of the options is another's. As many
  // meshes are stored at a time as there are `writers`, which wait for the disk while others work. What is being stored
  // when this goes is waited for. `scratch`: of the stage; it outlives this.
  DiskStore(std::shared_ptr<const RoutedRun> run, std::filesystem::path out, StoreOptions options,
            std::uint32_t writers, TileStorage& scratch);
  Result<LoadedTile> load_points(TileId tile) override;
  // Written to the tile's file in `out`, under a temporary name.
  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override;
  Status take_early(TileId tile, BigVector<std::byte>& stored) override;
  // The tile's scratch goes when its result is on disk.
  void store(TileId tile, CollectedTile collected, Finished::Stored done) override;

 private:
  Result<std::vector<std::byte>> gather_rows(const TileMesh& mesh) const;
  template <class Write>
  auto written(TileId tile, const Write& write) const noexcept -> decltype(write());
  StoredEarly write_early(TileId tile, const EarlyFinals& cells) const;
  Result<Receipt> write_result(TileId tile, const CollectedTile& collected);

  std::shared_ptr<const RoutedRun> run_;
  std::filesystem::path out_;
  StoreOptions options_;
  TileStorage& scratch_;
  std::counting_semaphore<> early_;  // how many more may be stored early now
  Writers writers_;                  // last: they use all of the above
};

}  // namespace tessera

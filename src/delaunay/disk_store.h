// Delaunay tiles' points in a run folder, or in a result that has only them; their results in the store.
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <semaphore>
#include <span>
#include <vector>

#include "src/delaunay/delaunay_store.h"
#include "src/exchange/writers.h"
#include "src/result/store/tile_store.h"
#include "src/result/store/tile_taker.h"

namespace tessera {

// Where tiles' points are. For several threads at once.
class TilePoints {
 public:
  virtual ~TilePoints() = default;
  virtual int dimension() const = 0;
  virtual const std::vector<Attribute>& schema() const = 0;
  // As DelaunayStore::load_points().
  virtual Result<LoadedTile> load(TileId tile) const = 0;
  // What vertices of this tile's cells carry: rows of the schema. Error corrupt when one is missing.
  virtual Result<std::vector<std::byte>> rows(TileId tile, std::span<const PointId> ids,
                                              std::span<const TileId> owners) const = 0;
};
std::shared_ptr<const TilePoints> routed_points(std::shared_ptr<const RoutedCloud> run);

class DiskStore final : public DelaunayStore {
 public:
  // Results go to `out`; error io before anything is written there when the lock of the options is another's. As many
  // meshes are stored at a time as there are `writers`, which wait for the disk while others work. What is being stored
  // when this goes is waited for. `scratch`: of the stage; it outlives this, as `taker` does. If there is one, it gets
  // the tiles' cells, and no results are written.
  DiskStore(std::shared_ptr<const TilePoints> points, std::filesystem::path out, StoreOptions options,
            std::uint32_t writers, TileStorage& scratch, TileConsumer* taker);
  Result<LoadedTile> load_points(TileId tile) override;
  // Written to the tile's file in `out`, under a temporary name.
  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override;
  Status take_early(TileId tile, BigVector<std::byte>& stored) override;
  // The tile's scratch goes when its result is on disk.
  void store(TileId tile, CollectedTile collected, Finished::Stored done) override;
  void store_points(TileId tile, PointsOfTile kept, Finished::Stored done) override;

 private:
  template <class Write>
  auto written(TileId tile, const Write& write) const noexcept -> decltype(write());
  StoredEarly write_early(TileId tile, const EarlyFinals& cells) const;
  Result<Receipt> write_result(TileId tile, CollectedTile& collected);
  Result<TileEntry> give(TileId tile, CollectedTile& collected, std::vector<std::byte> rows);
  Result<Receipt> write_points(TileId tile, PointsOfTile& kept);
  template <class Tile, class Write>
  void write_later(TileId tile, Tile kept, Finished::Stored done, Write write);

  std::shared_ptr<const TilePoints> points_;
  std::filesystem::path out_;
  StoreOptions options_;
  TileStorage& scratch_;
  TileConsumer* taker_;
  std::counting_semaphore<> early_;  // how many more may be stored early now
  Writers writers_;                  // last: they use all of the above
};

}  // namespace tessera

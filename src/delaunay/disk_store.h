// Reads Delaunay tiles' points from a run folder, or from a result that is kept as points, and stores their results.
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

// Where tiles' points are. Thread-safe.
class TilePoints {
 public:
  virtual ~TilePoints() = default;
  virtual int dimension() const = 0;
  virtual const std::vector<Attribute>& schema() const = 0;
  // As DelaunayStore::load_points().
  virtual Result<LoadedTile> load(TileId tile) const = 0;
  // Returns the attributes of vertices of this tile's cells: ids.size() rows of the schema. `owners`: beside ids. Error
  // corrupt when a vertex is missing.
  virtual Result<std::vector<std::byte>> rows(TileId tile, std::span<const PointId> ids,
                                              std::span<const TileId> owners) const = 0;
};
// Returns the points of a run folder.
std::shared_ptr<const TilePoints> routed_points(std::shared_ptr<const RoutedCloud> run);

class DiskStore final : public DelaunayStore {
 public:
  // Results go to `out`; nothing is written there when another process holds the lock of the options (error io).
  // `writers` threads store that many meshes at a time, and wait for the disk while other threads work. The destructor
  // waits for what is being stored. `scratch` is that of the stage; `scratch` and `taker` outlive this object. If there
  // is a taker, it gets the tiles' cells, and no results are written.
  DiskStore(std::shared_ptr<const TilePoints> points, std::filesystem::path out, StoreOptions options,
            std::uint32_t writers, TileStorage& scratch, TileConsumer* taker);
  Result<LoadedTile> load_points(TileId tile) override;
  // Writes to the tile's file in `out`, under a temporary name.
  std::future<StoredEarly> store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) override;
  Status take_early(TileId tile, BigVector<std::byte>& stored) override;
  // The tile's scratch is removed when its result is on disk.
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
  std::counting_semaphore<> early_;  // how many more tiles may store early cells now
  Writers writers_;                  // last: the writers use all of the above
};

}  // namespace tessera

#include "src/delaunay/disk_store.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <map>
#include <new>
#include <utility>

#include "src/base/files/folder_lock.h"
#include "src/base/image.h"
#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/result/store/early_cells.h"
#include "src/result/store/points_tile.h"

namespace tessera {

namespace {

class PointsOfRun final : public TilePoints {
 public:
  explicit PointsOfRun(std::shared_ptr<const RoutedCloud> run) : run_(std::move(run)) {}
  int dimension() const override { return run_->dimension; }
  const std::vector<Attribute>& schema() const override { return run_->schema; }
  Result<LoadedTile> load(TileId tile) const override { return load_tile(*run_, tile); }

  // The rows of foreign vertices are in their owners' files. Images have the rows of their points.
  Result<std::vector<std::byte>> rows(TileId, std::span<const PointId> vertices,
                                      std::span<const TileId> owners) const override {
    const std::size_t width = row_bytes(run_->schema);
    std::vector<std::byte> rows(vertices.size() * width);
    if (width == 0) return rows;
    std::map<TileId, std::vector<std::size_t>> by_owner;
    for (std::size_t i = 0; i < owners.size(); ++i) by_owner[plain(owners[i])].push_back(i);
    ShuffleFileMaps maps(*run_);
    for (const auto& [owner, places] : by_owner) {
      std::vector<PointId> ids;
      ids.reserve(places.size());
      for (const std::size_t i : places) ids.push_back(plain(vertices[i]));
      BOOST_OUTCOME_TRY(part, load_rows(maps, owner, ids));
      for (std::size_t k = 0; k < places.size(); ++k) {
        std::memcpy(&rows[places[k] * width], &part[k * width], width);
      }
    }
    return rows;
  }

 private:
  std::shared_ptr<const RoutedCloud> run_;
};

}  // namespace

std::shared_ptr<const TilePoints> routed_points(std::shared_ptr<const RoutedCloud> run) {
  return std::make_shared<const PointsOfRun>(std::move(run));
}

DiskStore::DiskStore(std::shared_ptr<const TilePoints> points, std::filesystem::path out, StoreOptions options,
                     std::uint32_t writers, TileStorage& scratch, TileConsumer* taker)
    : points_(std::move(points)),
      out_(std::move(out)),
      options_(std::move(options)),
      scratch_(scratch),
      taker_(taker),
      early_(writers),
      writers_(writers) {}

Result<LoadedTile> DiskStore::load_points(TileId tile) { return points_->load(tile); }

// Returns what `write` returns, or why it could not run.
template <class Write>
auto DiskStore::written(TileId tile, const Write& write) const noexcept -> decltype(write()) {
  const auto name = [&] { return "tile " + std::to_string(tile.value); };
  try {
    throw_if_stopped(options_.stop);
    BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
    return write();
  } catch (const Stopped&) {
    return worded([&] { return error(Errc::interrupted, "interrupted while " + name() + " was stored"); });
  } catch (const std::bad_alloc&) {
    return worded([&] {
      return error(Errc::memory,
                   "out of memory while storing " + name() + ": use smaller tiles or a smaller " + option("memory"));
    });
  } catch (const std::exception& e) {
    return worded([&] { return error(Errc::internal, name() + " cannot be stored: " + e.what()); });
  }
}

// How much room the other cells need is known only when all have come. Cells that may still change become somewhat
// more, hardly ever twice as many.
DiskStore::StoredEarly DiskStore::write_early(TileId tile, const EarlyFinals& cells) const {
  const std::uint64_t others = cells.others();
  BOOST_OUTCOME_TRY(early, write_early_cells(out_, tile,
                                             {.dimension = points_->dimension(),
                                              .ids = cells.ids(),
                                              .cells = cells,
                                              .count = cells.early(),
                                              .room = cells.all() + others + others / 4 * 3 + 4096},
                                             options_));
  return bytes_of(early);
}

std::future<DiskStore::StoredEarly> DiskStore::store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) {
  auto promise = std::make_shared<std::promise<StoredEarly>>();
  auto stored = promise->get_future();
  early_.acquire();
  writers_.take([this, tile, cells = std::move(cells), promise = std::move(promise)]() mutable noexcept {
    StoredEarly early = written(tile, [&] { return write_early(tile, *cells); });
    cells.reset();
    early_.release();
    promise->set_value(std::move(early));
  });
  return stored;
}

Status DiskStore::take_early(TileId tile, BigVector<std::byte>& stored) {
  auto early = early_cells_of(stored);
  if (!early)
    return error(Errc::corrupt,
                 "tile " + std::to_string(tile.value) + ": the record of the cells that were written early is damaged");
  BOOST_OUTCOME_TRYV(take_early_cells(out_, tile, *early, options_));
  stored = bytes_of(*early);
  return success();
}

Result<TileEntry> DiskStore::give(TileId tile, CollectedTile& collected, std::vector<std::byte> rows) {
  TileEntry entry;
  entry.tile = tile;
  entry.own_points = collected.own;
  StoredTile cells;
  cells.mesh = std::move(collected).whole();
  cells.schema = points_->schema();
  cells.rows = std::move(rows);
  entry.points = cells.mesh.points.size();
  entry.cells = cells.mesh.cell_ghost.size();
  entry.main_cells =
      static_cast<std::uint64_t>(std::count(cells.mesh.cell_ghost.begin(), cells.mesh.cell_ghost.end(), 0));
  BOOST_OUTCOME_TRYV(taker_->take(tile, cells));
  return entry;
}

Result<Receipt> DiskStore::write_result(TileId tile, CollectedTile& collected) {
  BOOST_OUTCOME_TRY(rows, points_->rows(tile, collected.mesh.ids, collected.mesh.owners));
  if (taker_) {
    BOOST_OUTCOME_TRY(given, give(tile, collected, std::move(rows)));
    BOOST_OUTCOME_TRYV(remove_beginnings(scratch_, tile));
    return bytes_of(given);
  }
  const auto early = early_cells_of(collected.stored);
  if (collected.early > 0 && (!early || early->cells != collected.early))
    return error(Errc::internal, "tile " + std::to_string(tile.value) + " has lost the cells that were written early");
  BOOST_OUTCOME_TRY(entry, write_tile(out_, tile, collected.mesh, collected, rows, options_,
                                      collected.early > 0 ? &*early : nullptr));
  BOOST_OUTCOME_TRYV(remove_beginnings(scratch_, tile));
  return bytes_of(entry);
}

Result<Receipt> DiskStore::write_points(TileId tile, PointsOfTile& kept) {
  const std::uint64_t own = kept.points.size();
  const auto owners = kept.append_foreign(tile);
  BOOST_OUTCOME_TRY(rows, points_->rows(tile, kept.ids, owners));
  BOOST_OUTCOME_TRY(entry, write_points_tile(out_,
                                             {.dimension = points_->dimension(),
                                              .tile = tile,
                                              .own = own,
                                              .points = kept.points,
                                              .ids = kept.ids,
                                              .owners = owners,
                                              .schema = points_->schema(),
                                              .rows = rows},
                                             kept.counted, options_));
  BOOST_OUTCOME_TRYV(remove_beginnings(scratch_, tile));
  return bytes_of(entry);
}

template <class Tile, class Write>
void DiskStore::write_later(TileId tile, Tile kept, Finished::Stored done, Write write) {
  auto held = std::make_shared<Tile>(std::move(kept));  // shared, as tasks must be copyable
  writers_.take([this, tile, held = std::move(held), done = std::move(done), write]() mutable noexcept {
    Result<Receipt> receipt = written(tile, [&] { return (this->*write)(tile, *held); });
    held.reset();  // before the node counts its memory as free
    done(std::move(receipt));
  });
}

void DiskStore::store(TileId tile, CollectedTile collected, Finished::Stored done) {
  write_later(tile, std::move(collected), std::move(done), &DiskStore::write_result);
}

void DiskStore::store_points(TileId tile, PointsOfTile kept, Finished::Stored done) {
  write_later(tile, std::move(kept), std::move(done), &DiskStore::write_points);
}

}  // namespace tessera

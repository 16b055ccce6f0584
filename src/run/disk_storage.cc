#include "src/run/disk_storage.h"

#include <cstring>
#include <exception>
#include <map>
#include <new>
#include <system_error>
#include <utility>

#include "src/base/option.h"
#include "src/base/stopped.h"
#include "src/files/folder.h"
#include "src/files/folder_lock.h"
#include "src/files/handed_file.h"
#include "src/files/there.h"
#include "src/store/early_cells.h"

namespace tessera {
namespace {

Error refused(const std::filesystem::path& path, const char* what, const std::error_code& reason) {
  return error(Errc::io, path.string() + ": cannot " + what + ": " + reason.message());
}

Status make_folder_of(const std::filesystem::path& file) {
  std::error_code failed;
  std::filesystem::create_directories(file.parent_path(), failed);
  if (failed) return refused(file.parent_path(), "make the folder", failed);
  return success();
}

Result<TileStorage::Pieces> pieces_of(const std::filesystem::path& file, ScratchKind kind, const FrameOwner& owner) {
  TileStorage::Pieces pieces;
  BOOST_OUTCOME_TRY(there, is_there(file));
  if (!there) return pieces;
  BOOST_OUTCOME_TRYV(for_each_frame(file, kind, owner, [&](BigVector<std::byte> payload) -> Status {
    pieces.push_back(std::move(payload));
    return success();
  }));
  return pieces;
}

Status remove_file(const std::filesystem::path& file) {
  std::error_code failed;
  std::filesystem::remove(file, failed);
  if (failed) return refused(file, "remove it", failed);
  return success();
}

}  // namespace

DiskStorage::DiskStorage(std::shared_ptr<const RoutedRun> run, std::filesystem::path scratch, std::filesystem::path out,
                         StoreOptions options, std::uint32_t writers)
    : run_(std::move(run)),
      scratch_(std::move(scratch)),
      out_(std::move(out)),
      options_(std::move(options)),
      settled_(run_->folder, run_->seal, options_.node),
      early_(writers),
      writers_(writers) {}

const std::filesystem::path& DiskStorage::folder_of(ScratchKind what) const {
  return what == ScratchKind::duplicates ? run_->folder : scratch_;  // all duplicates are gathered at the end
}

template <class Outcome>
Outcome DiskStorage::on(ScratchKind what, Outcome outcome) {
  if (!outcome && outcome.error().code == Errc::io && folder_of(what) != run_->folder) own_scratch_failed_ = true;
  return outcome;
}

Result<LoadedTile> DiskStorage::load_points(TileId tile) { return load_tile(*run_, tile); }

Status DiskStorage::write(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  if (what == ScratchKind::settled) return settled_.append(tile, bytes);
  const auto path = scratch_file(folder_of(what), what, tile);
  BOOST_OUTCOME_TRYV(on(what, make_folder_of(path)));
  return on(what, write_frame(path, what, owner_of(tile), bytes));
}

Status DiskStorage::hand_over(TileId tile, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  const auto path = handed_file(run_->folder, tile);
  BOOST_OUTCOME_TRYV(make_folder_of(path));
  return write_frame(path, ScratchKind::state, owner_of(tile), bytes);
}

Result<TileStorage::Pieces> DiskStorage::handed(TileId tile) {
  return pieces_of(handed_file(run_->folder, tile), ScratchKind::state, owner_of(tile));
}

Status DiskStorage::forget_handed(TileId tile) { return remove_file(handed_file(run_->folder, tile)); }

Status DiskStorage::append(TileId tile, ScratchKind what, std::span<const std::byte> bytes) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  const auto path = scratch_file(folder_of(what), what, tile);
  BOOST_OUTCOME_TRYV(on(what, make_folder_of(path)));
  return on(what, append_frame(path, what, owner_of(tile), bytes));
}

Result<bool> DiskStorage::has(TileId tile, ScratchKind what) {
  if (what == ScratchKind::settled) return settled_.has(tile);
  return on(what, is_there(scratch_file(folder_of(what), what, tile)));
}

Result<TileStorage::Pieces> DiskStorage::read(TileId tile, ScratchKind what) {
  Pieces pieces;
  if (what == ScratchKind::settled) {
    BOOST_OUTCOME_TRY(bytes, settled_.read(tile));
    if (bytes) pieces.push_back(std::move(*bytes));
    return pieces;
  }
  return on(what, pieces_of(scratch_file(folder_of(what), what, tile), what, owner_of(tile)));
}

Status DiskStorage::remove(TileId tile, ScratchKind what) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  return on(what, remove_file(scratch_file(folder_of(what), what, tile)));
}

Status DiskStorage::clear(ScratchKind what) {
  BOOST_OUTCOME_TRYV(check_held(options_.lock_file));
  if (what == ScratchKind::settled) return settled_.clear();
  const auto folder = scratch_folder(folder_of(what), what);
  if (const auto failed = remove_tree(folder)) return on(what, Status(refused(folder, "remove it", failed)));
  return success();
}

// Foreign vertices' rows stand in their owners' files.
Result<std::vector<std::byte>> DiskStorage::gather_rows(const TileMesh& mesh) const {
  const std::size_t width = row_bytes(run_->schema);
  std::vector<std::byte> rows(mesh.points.size() * width);
  if (width == 0) return rows;
  std::map<TileId, std::vector<std::size_t>> by_owner;
  for (std::size_t i = 0; i < mesh.owners.size(); ++i) by_owner[mesh.owners[i]].push_back(i);
  BundleMaps maps(*run_);
  for (const auto& [owner, places] : by_owner) {
    std::vector<PointId> ids;
    ids.reserve(places.size());
    for (const std::size_t i : places) ids.push_back(mesh.ids[i]);
    BOOST_OUTCOME_TRY(part, load_rows(maps, owner, ids));
    for (std::size_t k = 0; k < places.size(); ++k) {
      std::memcpy(&rows[places[k] * width], &part[k * width], width);
    }
  }
  return rows;
}

// What `write` gives, or why it could not.
template <class Write>
auto DiskStorage::written(TileId tile, const Write& write) const noexcept -> decltype(write()) {
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

// How much room the other cells need is known when all have come: cells that may still change become some more, hardly
// ever twice as many.
DiskStorage::StoredEarly DiskStorage::write_early(TileId tile, const EarlyFinals& cells) const {
  const std::uint64_t others = cells.others();
  BOOST_OUTCOME_TRY(early, write_early_cells(out_, tile,
                                             {.dimension = run_->dimension,
                                              .ids = cells.ids(),
                                              .cells = cells,
                                              .count = cells.early(),
                                              .room = cells.all() + others + others / 4 * 3 + 4096},
                                             options_));
  return bytes_of(early);
}

std::future<DiskStorage::StoredEarly> DiskStorage::store_early(TileId tile, std::shared_ptr<const EarlyFinals> cells) {
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

Status DiskStorage::take_early(TileId tile, BigVector<std::byte>& stored) {
  auto early = early_cells_of(stored);
  if (!early) return error(Errc::corrupt, "what tells of a tile's first cells is damaged");
  BOOST_OUTCOME_TRYV(take_early_cells(out_, tile, *early, options_));
  stored = bytes_of(*early);
  return success();
}

Result<TileEntry> DiskStorage::write_result(TileId tile, const CollectedTile& collected) {
  BOOST_OUTCOME_TRY(rows, gather_rows(collected.mesh));
  const auto early = early_cells_of(collected.stored);
  if (collected.early > 0 && (!early || early->cells != collected.early))
    return error(Errc::internal, "tile " + std::to_string(tile.value) + " has lost its first cells");
  BOOST_OUTCOME_TRY(entry, write_tile(out_, tile, collected.mesh, collected, rows, options_,
                                      collected.early > 0 ? &*early : nullptr));
  BOOST_OUTCOME_TRYV(remove_beginnings(*this, tile));
  return std::move(entry);
}

void DiskStorage::store(TileId tile, CollectedTile collected, Stored done) {
  auto held = std::make_shared<CollectedTile>(std::move(collected));  // a task can be copied
  writers_.take([this, tile, held = std::move(held), done = std::move(done)]() mutable noexcept {
    Result<TileEntry> entry = written(tile, [&] { return write_result(tile, *held); });
    held.reset();  // before the node believes that it is gone
    done(std::move(entry));
  });
}

}  // namespace tessera

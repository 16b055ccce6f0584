#include "src/surface/working_tiles.h"

#include <algorithm>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"

namespace tessera::surface {

Result<std::unique_ptr<SurfaceTile>> WorkingTiles::from_result(std::size_t index) const {
  BOOST_OUTCOME_TRY(stored, source_.read(index, {.rows = !source_.manifest().schema.empty()}));
  BOOST_OUTCOME_TRY(tile,
                    SurfaceTile::make(source_.entry(index).tile, source_.file(index).string(), std::move(stored)));
  return std::make_unique<SurfaceTile>(std::move(tile));
}

Result<std::unique_ptr<SurfaceTile>> WorkingTiles::take(std::size_t index) {
  {
    std::unique_lock lock(mutex_);
    written_.wait(lock, [&] { return on_disk_[index] != OnDisk::soon; });
    if (const auto found = here_.find(index); found != here_.end()) {
      auto tile = std::move(found->second);
      here_.erase(found);
      order_.remove(index);
      held_ -= tile->bytes();
      return tile;
    }
    if (on_disk_[index] == OnDisk::no) {
      lock.unlock();
      return from_result(index);
    }
  }
  BOOST_OUTCOME_TRY(tile, SurfaceTile::load_cells(source_.entry(index).tile, source_.file(index).string(),
                                                  cells_path(index), source_.manifest().schema));
  return std::make_unique<SurfaceTile>(std::move(tile));
}

Status WorkingTiles::give_back(std::size_t index, std::unique_ptr<SurfaceTile> tile) {
  Leaving leaving;
  {
    const std::lock_guard lock(mutex_);
    held_ += tile->bytes();
    here_[index] = std::move(tile);
    order_.push_back(index);
    leaving = too_much();
  }
  return put_down(std::move(leaving));
}

WorkingTiles::Leaving WorkingTiles::too_much() {
  Leaving leaving;
  while (held_ > memory_bytes_) {
    // Passes go through the tiles in one order, so the tile used last is needed last.
    const std::size_t last = order_.back();
    order_.pop_back();
    auto found = here_.find(last);
    held_ -= found->second->bytes();
    leaving.emplace_back(last, std::move(found->second));
    here_.erase(found);
    on_disk_[last] = OnDisk::soon;
  }
  return leaving;
}

Status WorkingTiles::put_down(Leaving leaving) {
  Status all = success();
  for (auto& [number, one] : leaving) {
    Status saved = put_down(number, *one);
    one = nullptr;
    if (!saved && all) all = std::move(saved);
    const std::lock_guard lock(mutex_);
    on_disk_[number] = OnDisk::yes;  // also after an error, which ends the job
    written_.notify_all();
  }
  return all;
}

Status WorkingTiles::put_down(std::size_t index, const SurfaceTile& tile) const {
  BOOST_OUTCOME_TRY(cells, is_there(cells_path(index)));
  return cells ? Status(success()) : tile.save_cells(cells_path(index));
}

}  // namespace tessera::surface

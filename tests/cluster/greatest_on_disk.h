// The program of tests/exchange/greatest.h as a stage after the triangulation, with results on disk.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/files/there.h"
#include "src/files/whole_file.h"
#include "src/run/next_stage.h"
#include "src/store/tile_reader.h"
#include "src/store/tile_store.h"
#include "tests/exchange/greatest.h"

namespace tessera::testing {

inline std::uint64_t number_of(TileId tile) { return tile.value * 7919ULL % 1009; }

// That the tile's cells have vertices of, as it is stored.
inline Result<std::vector<TileId>> touched(const std::filesystem::path& out, TileId tile) {
  BOOST_OUTCOME_TRY(stored, store::read_tile(tile_file(out, tile), tile, {.cells = false}));
  std::set<TileId> owners(stored.mesh.owners.begin(), stored.mesh.owners.end());
  owners.erase(tile);
  return std::vector<TileId>(owners.begin(), owners.end());
}

class GreatestOnDisk final : public NextStage {
 public:
  // `folder`: of the results, and of `hold`: while that file is there, no tile begins.
  explicit GreatestOnDisk(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path hold() const { return folder_ / "hold"; }
  // Made by a process when the first of its tiles is to begin.
  std::filesystem::path begun(const std::string& name) const { return folder_ / ("begun-" + name); }
  std::filesystem::path result(TileId tile) const { return folder_ / (std::to_string(tile.value) + ".number"); }
  std::string name;  // of this process

  std::shared_ptr<const TilePrograms> programs(const StageInput& input) override {
    auto stage = std::make_shared<GreatestStage>();
    stage->number = number_of;
    stage->neighbours = [this, out = input.out, stop = input.stop](TileId tile) -> Result<std::vector<TileId>> {
      std::call_once(told_, [&] { std::ofstream(begun(name)) << "begun\n"; });
      while (!stop.stop_requested()) {
        BOOST_OUTCOME_TRY(held, is_there(hold()));
        if (!held) break;
        std::this_thread::yield();
      }
      return touched(out, tile);
    };
    stage->keep = [this](TileId tile, std::uint64_t number) {
      return write_whole(result(tile), std::to_string(number));
    };
    return stage;
  }
  Result<std::vector<TileReceipt>> stored(const std::filesystem::path&) override {
    std::vector<TileReceipt> stored;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      if (entry.path().extension() != ".number") continue;
      stored.push_back({TileId{static_cast<std::uint32_t>(std::stoul(entry.path().stem()))}, {}});
    }
    return stored;
  }

 private:
  std::filesystem::path folder_;
  std::once_flag told_;
};

}  // namespace tessera::testing

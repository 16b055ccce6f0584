// The program of tests/exchange/greatest.h as a job over a result, of two stages, with its numbers on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/files/folder.h"
#include "src/base/files/there.h"
#include "src/base/files/whole_file.h"
#include "src/delaunay/run/result_stages.h"
#include "tests/exchange/greatest.h"

namespace tessera::testing {

inline constexpr const char* kind_of_greatest = "greatest";

inline std::uint64_t number_of(TileId tile) { return tile.value * 7919ULL % 1009; }

// That the tile's cells have vertices of.
inline Result<std::vector<TileId>> touched(const TileSource& source, TileId tile) {
  BOOST_OUTCOME_TRY(stored, source.read(*source.find(tile), {.cells = false}));
  std::set<TileId> owners(stored.mesh.owners.begin(), stored.mesh.owners.end());
  owners.erase(tile);
  return std::vector<TileId>(owners.begin(), owners.end());
}

// What a tile has in the second stage is what the first has found.
class GreatestOnDisk final : public ResultStages {
 public:
  // While the file hold() is there, no tile begins a stage.
  static std::filesystem::path hold(const std::filesystem::path& run, std::uint32_t stage) {
    return run / ("hold-" + std::to_string(stage));
  }
  // Made by a node when the first of its tiles is to begin a stage.
  static std::filesystem::path begun(const std::filesystem::path& run, std::uint32_t stage, const std::string& name) {
    return run / ("begun-" + std::to_string(stage) + "-" + name);
  }
  static Result<std::uint64_t> found(const std::filesystem::path& run, std::uint32_t stage, TileId tile) {
    BOOST_OUTCOME_TRY(bytes, read_whole(numbers(run, stage) / std::to_string(tile.value)));
    return std::stoull(std::string(as_text(bytes)));
  }

  explicit GreatestOnDisk(std::string name) : name_(std::move(name)) {}  // of the node
  std::uint32_t count() const override { return 2; }
  Result<std::vector<std::shared_ptr<const TilePrograms>>> programs(const ResultInput& input) const override {
    std::vector<std::shared_ptr<const TilePrograms>> programs;
    for (std::uint32_t stage = 0; stage < count(); ++stage) programs.push_back(programs_of(stage, input));
    return programs;
  }
  Result<std::vector<TileReceipt>> stored(const std::filesystem::path& run, std::uint32_t stage) const override {
    std::vector<TileReceipt> stored;
    BOOST_OUTCOME_TRY(there, is_there(numbers(run, stage)));
    if (!there) return stored;
    BOOST_OUTCOME_TRY(names, sorted_names(numbers(run, stage)));
    for (const std::string& name : names) {
      if (name.find('.') == name.npos) stored.push_back({TileId{static_cast<std::uint32_t>(std::stoul(name))}, {}});
    }
    return stored;
  }
  std::uint64_t work_bytes(const TileSource&, std::size_t) const override { return 4096; }

 private:
  static std::filesystem::path numbers(const std::filesystem::path& run, std::uint32_t stage) {
    return run / ("numbers-" + std::to_string(stage));
  }
  std::shared_ptr<const TilePrograms> programs_of(std::uint32_t stage, const ResultInput& input) const {
    auto programs = std::make_shared<GreatestStage>();
    programs->number = [stage, run = input.run](TileId tile) {
      return stage == 0 ? number_of(tile) : found(run, stage - 1, tile).value();
    };
    const auto told = std::make_shared<std::once_flag>();
    programs->neighbours = [name = name_, stage, told, source = input.source, run = input.run,
                            stop = input.stop](TileId tile) -> Result<std::vector<TileId>> {
      std::call_once(*told, [&] { std::ofstream(begun(run, stage, name)) << "begun\n"; });
      while (!stop.stop_requested()) {
        BOOST_OUTCOME_TRY(held, is_there(hold(run, stage)));
        if (!held) break;
        std::this_thread::yield();
      }
      return touched(source, tile);
    };
    programs->keep = [stage, run = input.run](TileId tile, std::uint64_t number) -> Status {
      BOOST_OUTCOME_TRYV(make_directories(numbers(run, stage)));
      return write_whole(numbers(run, stage) / std::to_string(tile.value), std::to_string(number));
    };
    return programs;
  }

  const std::string name_;
};

}  // namespace tessera::testing

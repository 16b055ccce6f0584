#include "src/surface/join_work.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

#include "src/surface/groups.h"
#include "src/surface/region.h"

namespace tessera::surface {

namespace {

constexpr SurfaceStageId first_step = SurfaceStageId::groups;
unsigned level_of(SurfaceStageId step) { return static_cast<unsigned>(step) - static_cast<unsigned>(first_step) + 1; }
StepOutput sides_of_level(unsigned level) {
  return output_of(static_cast<SurfaceStageId>(static_cast<unsigned>(first_step) + level - 1));
}
// Returns the kind of what groups of a level have left; level 0: tiles.
StepOutput kernel_of_level(unsigned level) {
  static_assert(static_cast<unsigned>(StepOutput::district_kernel) == static_cast<unsigned>(StepOutput::kernel) + 2);
  return static_cast<StepOutput>(static_cast<unsigned>(StepOutput::kernel) + level);
}

std::optional<std::size_t> number_of(const StepInput& input, TileId tile) {
  const auto at = std::lower_bound(input.tiles.begin(), input.tiles.end(), tile);
  if (at == input.tiles.end() || *at != tile) return std::nullopt;
  return static_cast<std::size_t>(at - input.tiles.begin());
}

}  // namespace

Result<Bytes> JoinWork::end(TileId self, const PieceInbox&) const {
  const Groups groups(input().tiles.size(), options().together);
  const unsigned level = level_of(step_);
  const std::size_t first = *number_of(input(), self);
  if (groups.first_of(first, level) != first) return Bytes();
  std::vector<ReducedRegion> regions;
  for (std::size_t i = 0; i < groups.members(first, level); ++i) {
    const TileId tile = input().tiles[groups.member(first, level, i)];
    BOOST_OUTCOME_TRY(region, kept<ReducedRegion>(kernel_of_level(level - 1), tile));
    regions.push_back(std::move(region));
  }
  const auto region_of = [&](TileId tile) -> std::optional<std::uint32_t> {
    const auto number = number_of(input(), tile);
    if (!number || groups.first_of(*number, level) != first) return std::nullopt;
    return static_cast<std::uint32_t>(groups.member_of(*number, level));
  };
  BOOST_OUTCOME_TRY(joined, join(regions, region_of));
  regions.clear();
  throw_if_stopped(input().stop);
  const std::uint32_t cells = joined.region.graph.cells();
  if (step_ == SurfaceStageId::cut && !joined.region.names.empty())
    return error(Errc::corrupt, "a tile has a border towards tile " + to_string(joined.region.names.front().to) +
                                    ", which is missing");
  BOOST_OUTCOME_TRY(kernel, kernel_of(std::move(joined.region), options().prove));
  if (step_ != SurfaceStageId::cut) {
    BOOST_OUTCOME_TRYV(store().write(kernel_of_level(level), self, bytes_of(kernel)));
  }
  return bytes_of(KeptGroup{cells, std::move(joined.first), std::move(kernel.sources), std::move(kernel.open)});
}

Result<cut::CellSet> decided_together(const KeptWork& work, TileId self, std::uint64_t undecided) {
  const StepInput& input = work.input();
  const Groups groups(input.tiles.size(), work.options().together);
  const std::size_t number = *number_of(input, self);
  cut::CellSet sources(undecided);
  std::vector<std::uint32_t> left(undecided);
  std::iota(left.begin(), left.end(), std::uint32_t{0});
  std::uint64_t before = 0;  // what this member of the group has left before the tile's own cells
  for (unsigned level = 1; level <= Groups::levels && !left.empty(); ++level) {
    const TileId host = input.tiles[groups.first_of(number, level)];
    BOOST_OUTCOME_TRY(group, work.kept<KeptGroup>(sides_of_level(level), host));
    const std::size_t member = groups.member_of(number, level);
    const bool whole = member < group.first.size() && group.sources.holds(group.cells) && group.open.holds(group.cells);
    if (!whole || group.first[member] + before + left.size() > group.cells) return damaged(host, "state");
    auto cell = static_cast<std::uint32_t>(group.first[member] + before);
    before = group.open.count_before(cell);
    std::size_t stay = 0;
    for (const std::uint32_t own : left) {
      if (group.open.contains(cell)) {
        left[stay++] = own;
      } else if (group.sources.contains(cell)) {
        sources.insert(own);
      }
      ++cell;
    }
    left.resize(stay);
  }
  if (!left.empty()) return damaged(self, "state");
  return sources;
}

}  // namespace tessera::surface

// The way of a result's tiles to their triangles: one pass over all of them after the other, with mail between.
//
//   scales    | of each own vertex, by its edges; of all of them the median
//   rays      | of own vertices; then as often as rays have gone to other tiles, in those
//   arcs      | facets' main tiles, which have heard of all rays now, tell cells' main tiles of arcs
//   regions   | each tile's graph, and what it decides alone; what is left is kept
//   cut       | of all that is left, at once
//   labels    | cells' main tiles tell the others that hold them
//   triangles | are handed on
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <stop_token>
#include <vector>

#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/surface/post.h"
#include "src/surface/ray_caster.h"
#include "src/surface/records.h"
#include "src/surface/region.h"
#include "src/surface/sensors.h"
#include "src/surface/shelf.h"
#include "src/surface/triangles.h"
#include "src/surface/umbrellas.h"

namespace tessera::surface {

struct PassesOptions {
  Energy energy;
  CutRule rule;
  Boundary boundary;
  bool splits = false;  // tells what is to be split where the surface is not manifold
  bool prove = false;   // each cut by its flow
  std::uint64_t memory_bytes = 0;
  unsigned threads = 1;
  std::function<void(double)> progress = {};
  std::stop_token stop = {};
};

struct Counts {
  double sigma = 0;
  std::atomic<std::uint64_t> rays{0}, no_rays{0}, guessed{0}, steps{0}, undecided{0}, outside{0};
  std::uint64_t handed_over = 0;
};

class Passes {
 public:
  // `scratch`: an empty folder.
  static Result<std::unique_ptr<Passes>> begin(const TileSource& source, Sensors sensors,
                                               const std::filesystem::path& scratch, PassesOptions options);
  // Called by several threads, for each tile once. `splits`: if they were asked for.
  using Take = std::function<Status(std::size_t index, const StoredTile& triangles, Splits splits)>;
  Status run(const Take& take);
  const Counts& counts() const { return counts_; }

 private:
  Passes(const TileSource& source, Sensors sensors, const std::filesystem::path& scratch, PassesOptions options);
  using Work = std::function<Status(std::size_t index, SurfaceTile& tile)>;
  // Calls `work` for each tile for which `wanted` holds. `done`: the part of all work that has been done afterwards.
  Status pass(double done, const std::function<bool(std::size_t)>& wanted, const Work& work);

  Status find_scales(SurfaceTile& tile);
  Status find_sigma();
  Status cast(SurfaceTile& tile);
  Status follow(std::size_t index, SurfaceTile& tile);
  Status send_rays(SurfaceTile& tile, RayCaster& caster);
  Status tell_arcs(std::size_t index, SurfaceTile& tile);
  Status decide(std::size_t index, SurfaceTile& tile);
  Status solve();
  Result<std::vector<Label>> own_labels(std::size_t index, const SurfaceTile& tile);
  Status tell_labels(std::size_t index, SurfaceTile& tile);
  Status give_triangles(std::size_t index, const SurfaceTile& tile, const Take& take);
  Status take_votes(std::size_t index, SurfaceTile& tile);
  Result<std::size_t> place_of(TileId tile) const;
  template <class Record>
  auto to(Outgoing<Record>& outgoing, Status& status) const;

  const Sensors sensors_;
  PassesOptions options_;
  Solidity solidity_;
  Shelf shelf_;
  Post<RayRecord> rays_;
  Post<SumRecord> sums_;
  Post<VoteRecord> votes_;
  Post<ArcRecord> arcs_;
  Post<LabelRecord> labels_;
  std::uint64_t beside_ = 0;  // what a tile takes while it is worked on, beside what reading it takes
  std::mutex mutex_;
  std::vector<std::uint64_t> histogram_;  // of scales
  double done_ = 0;
  // By index: what a tile has decided, and of the cells that it has not, which are on the source's side.
  std::vector<RegionKernel> regions_;
  std::atomic<std::uint64_t> kernels_bytes_{0};
  std::vector<cut::CellSet> of_kernels_;
  Counts counts_;
};

}  // namespace tessera::surface

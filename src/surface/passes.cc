#include "src/surface/passes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "src/base/on_threads.h"
#include "src/files/folder.h"
#include "src/files/surface_names.h"
#include "src/files/whole_file.h"
#include "src/result/tile_queue.h"

namespace tessera::surface {

namespace {

// Of the memory three eighths are for tiles that wait, as much for those that are worked on, five kinds of mail share
// the rest. What tiles leave undecided takes from what tiles that wait have.
constexpr std::uint64_t mail_part = 64;
constexpr std::uint64_t tiles_part(std::uint64_t memory) { return memory / 8 * 3; }
// Bins of scales: exponent and first bits of a double, so that a bin is an eighth of a percent wide.
constexpr unsigned bin_shift = 43;
constexpr std::size_t bins = std::size_t{1} << (63 - bin_shift);

// Of a tile that is worked on: its mesh, stars and weights, its graph, a copy of that, trees.
constexpr std::uint64_t bytes_a_cell = 170;

constexpr double scales_done = 0.1, rays_done = 0.5, arcs_done = 0.6, regions_done = 0.8, labels_done = 0.9;

}  // namespace

Passes::Passes(const TileSource& source, Sensors sensors, const std::filesystem::path& scratch, PassesOptions options)
    : sensors_(std::move(sensors)),
      options_(std::move(options)),
      solidity_(source.manifest().schema),
      shelf_(source.stopped_by(options_.stop), surface_scratch(scratch, SurfaceScratch::tiles),
             tiles_part(options_.memory_bytes)),
      rays_(surface_scratch(scratch, SurfaceScratch::rays), source.tiles(), options_.memory_bytes / mail_part),
      sums_(surface_scratch(scratch, SurfaceScratch::sums), source.tiles(), options_.memory_bytes / mail_part),
      votes_(surface_scratch(scratch, SurfaceScratch::votes), source.tiles(), options_.memory_bytes / mail_part),
      arcs_(surface_scratch(scratch, SurfaceScratch::arcs), source.tiles(), options_.memory_bytes / mail_part),
      labels_(surface_scratch(scratch, SurfaceScratch::labels), source.tiles(), options_.memory_bytes / mail_part),
      regions_(source.tiles()) {
  for (std::size_t i = 0; i < source.tiles(); ++i)
    beside_ = std::max(beside_, source.entry(i).cells * bytes_a_cell -
                                    std::min(source.entry(i).cells * bytes_a_cell, source.work_bytes(i)));
}

Result<std::unique_ptr<Passes>> Passes::begin(const TileSource& source, Sensors sensors,
                                              const std::filesystem::path& scratch, PassesOptions options) {
  for (const auto what : {SurfaceScratch::tiles, SurfaceScratch::rays, SurfaceScratch::sums, SurfaceScratch::votes,
                          SurfaceScratch::arcs, SurfaceScratch::labels}) {
    BOOST_OUTCOME_TRYV(make_directories(surface_scratch(scratch, what)));
  }
  return std::unique_ptr<Passes>(new Passes(source, std::move(sensors), scratch, std::move(options)));
}

Result<std::size_t> Passes::place_of(TileId tile) const {
  const auto place = shelf_.source().find(tile);
  if (!place)
    return error(Errc::corrupt, shelf_.source().folder().string() + ": a vertex is of tile " + to_string(tile) +
                                    ", which the manifest does not have");
  return *place;
}

// A function that sends records; its first error is in `status`.
template <class Record>
auto Passes::to(Outgoing<Record>& outgoing, Status& status) const {
  return [this, &outgoing, &status](TileId tile, const Record& record) {
    if (!status) return;
    auto place = place_of(tile);
    status = place ? outgoing.add(place.value(), record) : Status(std::move(place).error());
  };
}

Status Passes::pass(double done, const std::function<bool(std::size_t)>& wanted, const Work& work) {
  std::vector<std::size_t> tiles;
  for (std::size_t i = 0; i < shelf_.source().tiles(); ++i)
    if (wanted(i)) tiles.push_back(i);
  TileQueue queue(shelf_.source(), std::move(tiles), options_.stop, [&](double part) {
    if (options_.progress) options_.progress(done_ + (done - done_) * part);
  });
  std::atomic<bool> failed{false};
  const unsigned threads = queue.threads(options_.threads, tiles_part(options_.memory_bytes), 1, beside_);
  BOOST_OUTCOME_TRYV(on_threads(threads, failed, [&]() -> Status {
    while (!failed) {
      BOOST_OUTCOME_TRY(index, queue.next());
      if (!index) break;
      BOOST_OUTCOME_TRY(tile, shelf_.take(*index));
      BOOST_OUTCOME_TRYV(work(*index, *tile));
      BOOST_OUTCOME_TRYV(shelf_.give_back(*index, std::move(tile)));
      queue.done();
    }
    return success();
  }));
  done_ = done;
  return success();
}

Status Passes::run(const Take& take) {
  const auto all = [](std::size_t) { return true; };
  if (options_.energy.sigma > 0) {
    counts_.sigma = options_.energy.sigma;
  } else {
    histogram_.assign(bins, 0);
    BOOST_OUTCOME_TRYV(pass(scales_done, all, [&](auto, auto& tile) { return find_scales(tile); }));
    BOOST_OUTCOME_TRYV(find_sigma());
  }
  BOOST_OUTCOME_TRYV(pass(rays_done, all, [&](auto, auto& tile) { return cast(tile); }));
  const auto waiting = [&](std::size_t i) { return rays_.any(i); };
  const auto any = [&] {
    for (std::size_t i = 0; i < shelf_.source().tiles(); ++i)
      if (waiting(i)) return true;
    return false;
  };
  while (any()) {
    BOOST_OUTCOME_TRYV(pass(rays_done, waiting, [&](auto i, auto& tile) { return follow(i, tile); }));
  }
  counts_.handed_over = rays_.sent();
  BOOST_OUTCOME_TRYV(pass(arcs_done, all, [&](auto i, auto& tile) { return tell_arcs(i, tile); }));
  BOOST_OUTCOME_TRYV(pass(regions_done, all, [&](auto i, auto& tile) { return decide(i, tile); }));
  BOOST_OUTCOME_TRYV(solve());
  BOOST_OUTCOME_TRYV(pass(labels_done, all, [&](auto i, auto& tile) { return tell_labels(i, tile); }));
  return pass(1, all, [&](auto i, auto& tile) { return give_triangles(i, tile, take); });
}

Status Passes::find_scales(SurfaceTile& tile) {
  auto& scales = tile.scales();
  scales.clear();
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) scales.push_back(tile.scale_of(v));
  tile.forget_marks();
  const std::lock_guard lock(mutex_);
  for (const double scale : scales) ++histogram_[std::bit_cast<std::uint64_t>(scale) >> bin_shift];
  return success();
}

// The median's bin, at its lower end: a function of all scales, whatever order they come in.
Status Passes::find_sigma() {
  std::uint64_t all = 0, below = 0;
  for (const auto count : histogram_) all += count;
  std::size_t bin = 0;
  while (bin + 1 < bins && below + histogram_[bin] <= all / 2) below += histogram_[bin++];
  counts_.sigma = std::bit_cast<double>(static_cast<std::uint64_t>(bin) << bin_shift);
  histogram_ = {};
  if (!(counts_.sigma > 0) || !std::isfinite(counts_.sigma))
    return error(Errc::usage, "the points are too near to each other, or too far apart, for a scale");
  return success();
}

Status Passes::cast(SurfaceTile& tile) {
  RayCaster caster(tile, options_.energy, shelf_.source().manifest().cells);
  const StoredTile& stored = tile.stored();
  const std::size_t width = row_bytes(stored.schema);
  std::uint64_t rays = 0, none = 0, guessed = 0;
  for (std::int32_t v = 0; v < tile.own_vertices(); ++v) {
    if (v % 4096 == 0 && options_.stop.stop_requested())
      return error(Errc::interrupted, "interrupted while casting rays");
    const auto at = static_cast<std::size_t>(v);
    const std::byte* row = stored.rows.data() + at * width;
    BOOST_OUTCOME_TRY(sensor, sensors_.of(tile.point(v), tile.id(v), row));
    if (!sensor) {
      ++none;
      continue;
    }
    ++rays;
    guessed += sensor->guessed ? 1 : 0;
    // Sparse and dense places have their own scale, but within bounds: an outlier's would reach through everything.
    const double sigma = options_.energy.sigma > 0
                             ? options_.energy.sigma
                             : std::clamp(tile.scales()[at], counts_.sigma / 4, counts_.sigma * 4);
    BOOST_OUTCOME_TRYV(caster.cast(v, sensor->at, sigma, solidity_.vote(row)));
  }
  counts_.rays += rays;
  counts_.no_rays += none;
  counts_.guessed += guessed;
  tile.scales() = {};
  return send_rays(tile, caster);
}

Status Passes::follow(std::size_t index, SurfaceTile& tile) {
  BOOST_OUTCOME_TRY(rays, rays_.take(index));
  RayCaster caster(tile, options_.energy, shelf_.source().manifest().cells);
  for (const RayRecord& ray : rays) {
    BOOST_OUTCOME_TRYV(caster.go_on(ray));
  }
  return send_rays(tile, caster);
}

Status Passes::send_rays(SurfaceTile& tile, RayCaster& caster) {
  const std::size_t tiles = shelf_.source().tiles();
  Outgoing rays(rays_, tiles);
  Outgoing sums(sums_, tiles);
  Outgoing votes(votes_, tiles);
  Status status = success();
  const auto ray = to(rays, status);
  for (const auto& [other, record] : caster.take_leaving()) ray(other, record);
  give_sums(tile, to(sums, status), to(votes, status));
  BOOST_OUTCOME_TRYV(std::move(status));
  counts_.steps += caster.steps();
  BOOST_OUTCOME_TRYV(rays.send());
  BOOST_OUTCOME_TRYV(sums.send());
  return votes.send();
}

Status Passes::take_votes(std::size_t index, SurfaceTile& tile) {
  BOOST_OUTCOME_TRY(votes, votes_.take(index));
  for (const VoteRecord& vote : votes) {
    BOOST_OUTCOME_TRYV(take_vote(tile, vote));
  }
  return success();
}

Status Passes::tell_arcs(std::size_t index, SurfaceTile& tile) {
  BOOST_OUTCOME_TRY(sums, sums_.take(index));
  for (const SumRecord& sum : sums) {
    BOOST_OUTCOME_TRYV(take_sum(tile, sum));
  }
  const std::size_t tiles = shelf_.source().tiles();
  Outgoing arcs(arcs_, tiles);
  Outgoing votes(votes_, tiles);
  Status status = success();
  BOOST_OUTCOME_TRYV(give_arcs(tile, options_.energy, options_.rule, to(arcs, status), to(votes, status)));
  BOOST_OUTCOME_TRYV(std::move(status));
  BOOST_OUTCOME_TRYV(arcs.send());
  return votes.send();
}

Status Passes::decide(std::size_t index, SurfaceTile& tile) {
  BOOST_OUTCOME_TRYV(take_votes(index, tile));
  BOOST_OUTCOME_TRY(arcs, arcs_.take(index));
  BOOST_OUTCOME_TRY(region, region_of(tile, options_.energy, options_.rule, arcs));
  tile.forget_weights();
  BOOST_OUTCOME_TRY(kernel, kernel_of(std::move(region), options_.prove));
  regions_[index] = std::move(kernel);
  counts_.undecided += regions_[index].kernel.cells.size();
  regions_[index].kernel.cells = {};  // open tells the same
  kernels_bytes_ += regions_[index].bytes();
  return shelf_.give_up(regions_[index].bytes());
}

Status Passes::solve() {
  // The whole grows while the kernels go; its search trees and the sides of borders come on top.
  BOOST_OUTCOME_TRYV(shelf_.give_up(kernels_bytes_ / 2));
  std::vector<TileId> tiles;
  for (std::size_t i = 0; i < shelf_.source().tiles(); ++i) tiles.push_back(shelf_.source().entry(i).tile);
  BOOST_OUTCOME_TRY(sets, solve_together(regions_, tiles, options_.prove));
  of_kernels_ = std::move(sets);
  return success();
}

// Of cells that are main here; others are unknown.
Result<std::vector<Label>> Passes::own_labels(std::size_t index, const SurfaceTile& tile) {
  const RegionKernel& region = regions_[index];
  const Label source = options_.rule.unknown_inside ? Label::outside : Label::inside;
  const Label sink = options_.rule.unknown_inside ? Label::inside : Label::outside;
  std::vector<Label> labels(static_cast<std::size_t>(tile.cells()), Label::unknown);
  std::uint32_t cell = 0, of_kernel = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (!tile.is_main(static_cast<std::int32_t>(i))) continue;
    const bool is_source =
        region.open.contains(cell) ? of_kernels_[index].contains(of_kernel++) : region.sources.contains(cell);
    ++cell;
    labels[i] = is_source ? source : sink;
  }
  return labels;
}

Status Passes::tell_labels(std::size_t index, SurfaceTile& tile) {
  BOOST_OUTCOME_TRY(own, own_labels(index, tile));
  counts_.outside += static_cast<std::uint64_t>(std::count(own.begin(), own.end(), Label::outside));
  Outgoing labels(labels_, shelf_.source().tiles());
  Status status = success();
  give_labels(tile, own, to(labels, status));
  BOOST_OUTCOME_TRYV(std::move(status));
  return labels.send();
}

Status Passes::give_triangles(std::size_t index, const SurfaceTile& tile, const Take& take) {
  BOOST_OUTCOME_TRY(labels, own_labels(index, tile));
  BOOST_OUTCOME_TRY(told, labels_.take(index));
  for (const LabelRecord& record : told) {
    BOOST_OUTCOME_TRY(cell, tile.find(record.cell));
    labels[static_cast<std::size_t>(cell)] = record.outside != 0 ? Label::outside : Label::inside;
  }
  BOOST_OUTCOME_TRY(facets, facets_of(tile, labels, options_.rule, options_.boundary));
  Splits splits;
  if (options_.splits) {
    BOOST_OUTCOME_TRY(found, splits_of(tile, labels, options_.rule, options_.boundary, facets));
    splits = std::move(found);
  }
  return take(index, triangles_of(tile, facets), std::move(splits));
}

}  // namespace tessera::surface

#include "src/surface/steps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "src/base/flat_codec.h"
#include "src/base/stopped.h"
#include "src/surface/join_work.h"
#include "src/surface/kept_codec.h"
#include "src/surface/kept_work.h"
#include "src/surface/rays_program.h"
#include "src/surface/region.h"

namespace tessera::surface {

namespace {

// Bins of scales: the exponent and the first bits of a double. A bin is an eighth of a percent wide.
constexpr unsigned bin_shift = 43;
std::uint32_t bin_of(double scale) {
  return static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(scale) >> bin_shift);
}
double least_of(std::uint32_t bin) { return std::bit_cast<double>(std::uint64_t{bin} << bin_shift); }

struct BinRecord {
  std::uint32_t bin = 0, unused = 0;
  std::uint64_t scales = 0;
};

// Kinds of records in a step's mail.
enum Kind : std::uint32_t { bins, sums, votes, arcs, labels };

Error not_records(TileId self) {
  return error(Errc::internal, "tile " + to_string(self) + " has received a message that is not a list of records");
}

template <class Record>
auto adding(PieceOutbox& out, Kind kind) {
  return [&out, kind](TileId to, const Record& record) { out.add(to, kind, record); };
}

class ScalesWork final : public KeptWork {
 public:
  using KeptWork::KeptWork;
  Status tell(TileId self, PieceOutbox& out) const override {
    if (options().energy.sigma > 0) return success();
    BOOST_OUTCOME_TRY(tile, store().take(self));
    std::vector<double> scales;
    for (std::int32_t v = 0; v < tile->own_vertices(); ++v) {
      if (v % 4096 == 0) throw_if_stopped(input().stop);
      scales.push_back(tile->scale_of(v));
    }
    tile->forget_marks();
    BOOST_OUTCOME_TRYV(store().give_back(std::move(tile)));
    if (!is_first(self))
      for (const auto& [bin, count] : bins_of(scales)) out.add(input().tiles.front(), bins, BinRecord{bin, 0, count});
    FlatWriter kept;
    kept.list(scales);
    return store().write(StepOutput::own_scales, self, kept.take());
  }
  Result<Bytes> end(TileId self, const PieceInbox& told) const override {
    FlatWriter out;
    if (options().energy.sigma > 0 || !is_first(self)) {
      out.value(options().energy.sigma);
      return out.take();
    }
    BOOST_OUTCOME_TRY(bytes, store().read(StepOutput::own_scales, self));
    std::vector<double> scales;
    if (FlatReader in(bytes); !in.list(scales)) return damaged(self, "scales");
    auto counts = bins_of(scales);
    if (!told.for_each<BinRecord>(bins, [&](TileId, const BinRecord& record) { counts[record.bin] += record.scales; }))
      return not_records(self);
    BOOST_OUTCOME_TRY(median, median_of(counts));
    out.value(median);
    return out.take();
  }

 private:
  using Bins = std::map<std::uint32_t, std::uint64_t>;
  static Bins bins_of(const std::vector<double>& scales) {
    Bins counts;
    for (const double scale : scales) ++counts[bin_of(scale)];
    return counts;
  }
  // Returns the lower end of the median's bin: it does not depend on the order of the scales.
  static Result<double> median_of(const Bins& counts) {
    std::uint64_t all = 0, below = 0;
    for (const auto& [bin, count] : counts) all += count;
    double median = 0;
    for (const auto& [bin, count] : counts) {
      median = least_of(bin);
      if ((below += count) > all / 2) break;
    }
    if (!(median > 0) || !std::isfinite(median))
      return error(Errc::usage, "the points are too near to each other, or too far apart, to find a scale");
    return median;
  }
};

class SumsWork final : public KeptWork {
 public:
  using KeptWork::KeptWork;
  Status tell(TileId self, PieceOutbox& out) const override {
    BOOST_OUTCOME_TRY(rays, kept<KeptRays>(StepOutput::rays, self));
    BOOST_OUTCOME_TRY(tile, store().take(self));
    BOOST_OUTCOME_TRYV(tile->put_weights(std::move(rays.weights)));
    give_sums(*tile, adding<SumRecord>(out, sums), adding<VoteRecord>(out, votes));
    tile->forget_weights();
    return store().give_back(std::move(tile));
  }
  Result<Bytes> end(TileId, const PieceInbox& told) const override { return told.save(); }
};

class ArcsWork final : public KeptWork {
 public:
  using KeptWork::KeptWork;
  Status tell(TileId self, PieceOutbox& out) const override {
    BOOST_OUTCOME_TRY(mail, kept_mail(StepOutput::sums, self));
    BOOST_OUTCOME_TRY(tile, with_sums(self, mail));
    BOOST_OUTCOME_TRYV(give_arcs(*tile, options().energy, options().rule, adding<ArcRecord>(out, arcs),
                                 adding<VoteRecord>(out, votes)));
    tile->forget_weights();
    return store().give_back(std::move(tile));
  }
  Result<Bytes> end(TileId self, const PieceInbox& told) const override {
    BOOST_OUTCOME_TRY(mail, kept_mail(StepOutput::sums, self));
    BOOST_OUTCOME_TRY(tile, with_sums(self, mail));
    BOOST_OUTCOME_TRYV(take_votes(mail, *tile));
    BOOST_OUTCOME_TRYV(take_votes(told, *tile));
    std::vector<ArcRecord> records;
    if (!told.for_each<ArcRecord>(arcs, [&](TileId, const ArcRecord& record) { records.push_back(record); }))
      return not_records(self);
    BOOST_OUTCOME_TRY(region, region_of(*tile, options().energy, options().rule, records));
    tile->forget_weights();
    BOOST_OUTCOME_TRYV(store().give_back(std::move(tile)));
    throw_if_stopped(input().stop);
    if (options().together) return keep(self, all_of(std::move(region)));
    BOOST_OUTCOME_TRY(kernel, kernel_of(std::move(region), options().prove));
    return keep(self, std::move(kernel));
  }

 private:
  Result<Bytes> keep(TileId self, ReducedRegion kernel) const {
    BOOST_OUTCOME_TRYV(store().write(StepOutput::kernel, self, bytes_of(kernel)));
    return bytes_of(KeptSides{kernel.kernel.cells.size(), std::move(kernel.sources), std::move(kernel.open)});
  }
  // Returns the tile with the arcs that all rays have given to facets that are main here. Its own cells have only the
  // excess of rays that came here; the votes of other tiles are added later.
  Result<std::unique_ptr<SurfaceTile>> with_sums(TileId self, const PieceInbox& mail) const {
    BOOST_OUTCOME_TRY(rays, kept<KeptRays>(StepOutput::rays, self));
    BOOST_OUTCOME_TRY(tile, store().take(self));
    BOOST_OUTCOME_TRYV(tile->put_weights(std::move(rays.weights)));
    give_sums(
        *tile, [](TileId, const SumRecord&) {}, [](TileId, const VoteRecord&) {});
    Status status = success();
    const bool read = mail.for_each<SumRecord>(sums, [&](TileId, const SumRecord& sum) {
      if (status) status = take_sum(*tile, sum);
    });
    if (!read) return not_records(self);
    BOOST_OUTCOME_TRYV(std::move(status));
    return std::move(tile);
  }
  static Status take_votes(const PieceInbox& mail, SurfaceTile& tile) {
    Status status = success();
    const bool read = mail.for_each<VoteRecord>(votes, [&](TileId, const VoteRecord& vote) {
      if (status) status = take_vote(tile, vote);
    });
    return read ? std::move(status) : Status(not_records(tile.self()));
  }
};

class TrianglesWork final : public KeptWork {
 public:
  using KeptWork::KeptWork;
  Status tell(TileId self, PieceOutbox& out) const override {
    BOOST_OUTCOME_TRY(tile, store().take(self));
    BOOST_OUTCOME_TRY(own, own_labels(*tile));
    give_labels(*tile, own, adding<LabelRecord>(out, labels));
    return store().give_back(std::move(tile));
  }
  Result<Bytes> end(TileId self, const PieceInbox& told) const override {
    BOOST_OUTCOME_TRY(tile, store().take(self));
    BOOST_OUTCOME_TRY(sides, own_labels(*tile));
    KeptTriangles out;
    out.outside = static_cast<std::uint64_t>(std::count(sides.begin(), sides.end(), Label::outside));
    Status status = success();
    const bool read = told.for_each<LabelRecord>(labels, [&](TileId, const LabelRecord& record) {
      if (!status) return;
      auto cell = tile->find(record.cell);
      if (!cell) {
        status = std::move(cell).error();
      } else {
        sides[static_cast<std::size_t>(cell.value())] = record.outside != 0 ? Label::outside : Label::inside;
      }
    });
    if (!read) return not_records(self);
    BOOST_OUTCOME_TRYV(std::move(status));
    BOOST_OUTCOME_TRY(facets, facets_of(*tile, sides, options().rule, options().boundary));
    if (options().splits) {
      BOOST_OUTCOME_TRY(splits, splits_of(*tile, sides, options().rule, options().boundary, facets));
      out.splits = std::move(splits);
    }
    BOOST_OUTCOME_TRY(entry, store().keep_triangles(self, triangles_of(*tile, facets)));
    out.entry = std::move(entry);
    BOOST_OUTCOME_TRYV(store().give_back(std::move(tile)));
    return bytes_of(out);
  }

 private:
  // Returns the labels of cells that are main here; other labels are unknown.
  Result<std::vector<Label>> own_labels(const SurfaceTile& tile) const {
    BOOST_OUTCOME_TRY(alone, kept<KeptSides>(StepOutput::arcs, tile.self()));
    const bool fits = alone.sources.holds(static_cast<std::size_t>(main_cells(tile))) &&
                      alone.open.holds(static_cast<std::size_t>(main_cells(tile)));
    if (!fits) return damaged(tile.self(), "state");
    BOOST_OUTCOME_TRY(together, decided_together(*this, tile.self(), alone.undecided));
    const Label source = options().rule.unknown_inside ? Label::outside : Label::inside;
    const Label sink = options().rule.unknown_inside ? Label::inside : Label::outside;
    std::vector<Label> sides(static_cast<std::size_t>(tile.cells()), Label::unknown);
    std::uint32_t cell = 0, of_kernel = 0;
    for (std::size_t i = 0; i < sides.size(); ++i) {
      if (!tile.is_main(static_cast<std::int32_t>(i))) continue;
      const bool is_source = alone.open.contains(cell) ? together.contains(of_kernel++) : alone.sources.contains(cell);
      ++cell;
      sides[i] = is_source ? source : sink;
    }
    return sides;
  }
  static std::int64_t main_cells(const SurfaceTile& tile) {
    return std::count(tile.mesh().cell_ghost.begin(), tile.mesh().cell_ghost.end(), 0);
  }
};

std::unique_ptr<const StepWork> work_of(SurfaceStageId step, std::shared_ptr<const StepInput> input, StepStore& store) {
  switch (step) {
    case SurfaceStageId::scales:
      return std::make_unique<ScalesWork>(std::move(input), store);
    case SurfaceStageId::sums:
      return std::make_unique<SumsWork>(std::move(input), store);
    case SurfaceStageId::arcs:
      return std::make_unique<ArcsWork>(std::move(input), store);
    case SurfaceStageId::groups:
    case SurfaceStageId::districts:
    case SurfaceStageId::cut:
      return std::make_unique<JoinWork>(std::move(input), store, step);
    case SurfaceStageId::triangles:
      return std::make_unique<TrianglesWork>(std::move(input), store);
    case SurfaceStageId::rays:
      break;
  }
  return nullptr;
}

class StepPrograms final : public TilePrograms {
 public:
  StepPrograms(SurfaceStageId step, std::shared_ptr<const StepInput> input, std::shared_ptr<StepStore> store)
      : step_(step), input_(std::move(input)), store_(std::move(store)), work_(work_of(step, input_, *store_)) {}
  std::unique_ptr<TileProgram> program_of(TileId tile) const override {
    if (!work_) return std::make_unique<RaysProgram>(tile, input_, *store_);
    return std::make_unique<StepProgram>(tile, *work_, *store_, step_);
  }

 private:
  SurfaceStageId step_;
  std::shared_ptr<const StepInput> input_;
  std::shared_ptr<StepStore> store_;
  std::unique_ptr<const StepWork> work_;
};

}  // namespace

std::shared_ptr<const TilePrograms> programs_of(SurfaceStageId step, std::shared_ptr<const StepInput> input,
                                                std::shared_ptr<StepStore> store) {
  return std::make_shared<StepPrograms>(step, std::move(input), std::move(store));
}

Result<double> sigma_of(const StepInput& input, StepStore& store) {
  const TileId first = input.tiles.front();
  BOOST_OUTCOME_TRY(bytes, store.read(StepOutput::scales, first));
  double sigma = 0;
  if (!read(bytes, sigma) || !(sigma > 0)) return damaged(first, "scales");
  return sigma;
}

}  // namespace tessera::surface

#include "src/surface/region.h"

#include <algorithm>
#include <utility>

namespace tessera::surface {

namespace {

constexpr double down_min = 0.25;  // the square of the cosine of 60 degrees

}  // namespace

// Sides of the hull can lean over, where trees stand at the edge of a block; what is beyond them is not ground. So the
// normal of a facet must be within 60 degrees of straight down. The corners are taken in one order, so that all tiles
// agree.
bool is_inside_beyond(const SurfaceTile& tile, std::int32_t cell, std::size_t facet, const CutRule& rule) {
  if (!rule.lower_inside) return false;
  auto corners = tile.facet(cell, facet);
  std::rotate(
      corners.begin(),
      std::min_element(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.id < b.id; }),
      corners.end());
  const Point &o = corners[0].at, &p = corners[1].at, &q = corners[2].at;
  const double ax = p.x - o.x, ay = p.y - o.y, az = p.z - o.z, bx = q.x - o.x, by = q.y - o.y, bz = q.z - o.z;
  const double x = ay * bz - az * by, y = az * bx - ax * bz, z = ax * by - ay * bx;
  return z < 0 && z * z >= down_min * (x * x + y * y + z * z);
}

void give_sums(SurfaceTile& tile, const std::function<void(TileId, const SumRecord&)>& sum,
               const std::function<void(TileId, const VoteRecord&)>& vote) {
  for (std::int32_t cell = 0; cell < tile.cells(); ++cell) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::uint32_t& arc = tile.arc(cell, k);
      if (arc == 0) continue;
      const TileId to = tile.main_tile(cell, k);
      if (to == tile.self()) continue;
      sum(to, {tile.name(cell), tile.id(tile.vertex(cell, k)), arc});
      arc = 0;
    }
    std::int64_t& excess = tile.excess(cell);
    if (excess == 0 || tile.is_main(cell)) continue;
    vote(tile.main_tile(cell), {tile.name(cell), excess});
    excess = 0;
  }
}

Status take_sum(SurfaceTile& tile, const SumRecord& sum) {
  BOOST_OUTCOME_TRY(cell, tile.find(sum.cell));
  BOOST_OUTCOME_TRY(facet, tile.corner_of(cell, sum.opposite));
  std::uint32_t& arc = tile.arc(cell, facet);
  arc = saturating(arc, sum.weight);
  return success();
}

Status take_vote(SurfaceTile& tile, const VoteRecord& vote) {
  BOOST_OUTCOME_TRY(cell, tile.find(vote.cell));
  tile.excess(cell) += vote.votes;
  return success();
}

namespace {

std::uint32_t quality_of(const SurfaceTile& tile, std::int32_t cell, std::size_t k, std::int32_t across,
                         std::size_t across_k, const Energy& energy) {
  const auto facet = tile.facet(cell, k);
  const Corner apex = tile.corner(tile.vertex(cell, k));
  if (across < 0) return quality_weight(facet, apex, nullptr, energy);
  const Corner other = tile.corner(tile.vertex(across, across_k));
  return quality_weight(facet, apex, &other, energy);
}

std::int64_t hull_vote(const SurfaceTile& tile, std::int32_t cell, std::size_t k, const Energy& energy,
                       const CutRule& rule) {
  const std::int64_t weight = quality_of(tile, cell, k, SurfaceTile::outside, 0, energy);
  return is_inside_beyond(tile, cell, k, rule) ? -weight : weight;
}

}  // namespace

Status give_arcs(const SurfaceTile& tile, const Energy& energy, const CutRule& rule,
                 const std::function<void(TileId, const ArcRecord&)>& arc,
                 const std::function<void(TileId, const VoteRecord&)>& vote) {
  for (std::int32_t cell = 0; cell < tile.cells(); ++cell) {
    for (std::size_t k = 0; k < 4; ++k) {
      const std::int32_t across = tile.neighbor(cell, k);
      if (across == SurfaceTile::elsewhere || across > cell || tile.main_tile(cell, k) != tile.self()) continue;
      const TileId here = tile.main_tile(cell);
      if (across == SurfaceTile::outside) {
        const std::int64_t votes = here == tile.self() ? 0 : hull_vote(tile, cell, k, energy, rule);
        if (votes != 0) vote(here, {tile.name(cell), votes});
        continue;
      }
      const TileId there = tile.main_tile(across);
      if (here == tile.self() && there == tile.self()) continue;
      BOOST_OUTCOME_TRY(back, tile.corner_towards(across, cell));
      const std::uint32_t quality = quality_of(tile, cell, k, across, back, energy);
      ArcRecord record{.cell = tile.name(cell),
                       .opposite = tile.id(tile.vertex(cell, k)),
                       .across = tile.id(tile.vertex(across, back)),
                       .across_tile = there,
                       .out = saturating(tile.arc(cell, k), quality),
                       .in = saturating(tile.arc(across, back), quality)};
      if (here != tile.self()) arc(here, record);
      std::swap(record.opposite, record.across);
      std::swap(record.out, record.in);
      record.cell = tile.name(across);
      record.across_tile = here;
      if (there != tile.self()) arc(there, record);
    }
  }
  return success();
}

namespace {

std::array<PointId, 3> facet_name(const SurfaceTile& tile, std::int32_t cell, std::size_t k) {
  const auto corners = tile.facet(cell, k);
  std::array<PointId, 3> name{corners[0].id, corners[1].id, corners[2].id};
  std::sort(name.begin(), name.end());
  return name;
}

// Puts the arcs of a tile into a graph, one after the other.
class Builder {
 public:
  Builder(SurfaceTile& tile, const Energy& energy, const CutRule& rule)
      : tile_(tile), energy_(energy), rule_(rule), number_(static_cast<std::size_t>(tile.cells()), cut::no_arc) {
    std::uint32_t cells = 0;
    for (std::int32_t cell = 0; cell < tile.cells(); ++cell)
      if (tile.is_main(cell)) number_[static_cast<std::size_t>(cell)] = cells++;
    region_.graph.excess.assign(cells, 0);
    region_.graph.capacity.assign(std::size_t{4} * cells, 0);
    region_.graph.back.assign(std::size_t{4} * cells, cut::no_arc);
  }

  Status add_own() {
    for (std::int32_t cell = 0; cell < tile_.cells(); ++cell) {
      if (!tile_.is_main(cell)) continue;
      region_.graph.excess[number(cell)] += tile_.excess(cell);
      for (std::size_t k = 0; k < 4; ++k) {
        BOOST_OUTCOME_TRYV(add_own(cell, k));
      }
    }
    return success();
  }

  Status add(const ArcRecord& record) {
    BOOST_OUTCOME_TRY(cell, tile_.find(record.cell));
    BOOST_OUTCOME_TRY(k, tile_.corner_of(cell, record.opposite));
    if (!tile_.is_main(cell))
      return tile_.corrupt("another tile has sent an arc of a cell that is not main in this tile");
    if (record.across_tile != tile_.self()) {
      add_border(cell, k, record.across_tile, record.out, record.in);
      return success();
    }
    CellName other = record.cell;
    *std::find(other.begin(), other.end(), record.opposite) = record.across;
    std::sort(other.begin(), other.end());
    BOOST_OUTCOME_TRY(across, tile_.find(other));
    BOOST_OUTCOME_TRY(back, tile_.corner_of(across, record.across));
    if (!tile_.is_main(across))
      return tile_.corrupt("another tile has sent an arc to a cell that is not main in this tile");
    const cut::Arc arc = arc_of(cell, k);
    region_.graph.capacity[arc] = record.out;
    region_.graph.back[arc] = arc_of(across, back);
    return success();
  }

  // To get the greatest source set, source and sink change roles: the rest of the smallest source set of that graph is
  // the greatest set of this one.
  Result<CutRegion> take() {
    cut::CutGraph& graph = region_.graph;
    if (!rule_.unknown_inside) {
      for (auto& excess : graph.excess) excess = -excess;
      for (cut::Arc arc = 0; arc < graph.back.size(); ++arc)
        if (cut::is_inner(graph.back[arc]) && arc < graph.back[arc])
          std::swap(graph.capacity[arc], graph.capacity[graph.back[arc]]);
      for (auto& border : graph.borders) std::swap(border.capacity_in, graph.capacity[border.arc]);
    }
    if (!graph.sound()) return tile_.corrupt("its cells and those of its neighbours do not fit together");
    return std::move(region_);
  }

 private:
  std::uint32_t number(std::int32_t cell) const { return number_[static_cast<std::size_t>(cell)]; }
  cut::Arc arc_of(std::int32_t cell, std::size_t k) const { return 4 * number(cell) + static_cast<cut::Arc>(k); }

  Status add_own(std::int32_t cell, std::size_t k) {
    if (tile_.main_tile(cell, k) != tile_.self()) return success();  // another tile sends the arc
    const std::int32_t across = tile_.neighbor(cell, k);
    if (across == SurfaceTile::outside) {
      region_.graph.excess[number(cell)] += hull_vote(tile_, cell, k, energy_, rule_);
      return success();
    }
    if (across == SurfaceTile::elsewhere) return tile_.corrupt("a facet with an own vertex has an unknown neighbour");
    const bool both = tile_.is_main(across);
    if (both && across < cell) return success();
    BOOST_OUTCOME_TRY(back, tile_.corner_towards(across, cell));
    const std::uint32_t quality = quality_of(tile_, cell, k, across, back, energy_);
    const std::uint32_t out = saturating(tile_.arc(cell, k), quality),
                        in = saturating(tile_.arc(across, back), quality);
    if (!both) {
      add_border(cell, k, tile_.main_tile(across), out, in);
      return success();
    }
    const cut::Arc arc = arc_of(cell, k), arc_back = arc_of(across, back);
    cut::CutGraph& graph = region_.graph;
    graph.back[arc] = arc_back;
    graph.back[arc_back] = arc;
    graph.capacity[arc] = out;
    graph.capacity[arc_back] = in;
    return success();
  }

  void add_border(std::int32_t cell, std::size_t k, TileId to, std::uint32_t out, std::uint32_t in) {
    const cut::Arc arc = arc_of(cell, k);
    cut::CutGraph& graph = region_.graph;
    graph.capacity[arc] = out;
    graph.back[arc] = cut::border_bit | static_cast<cut::Arc>(graph.borders.size());
    graph.borders.push_back({arc, in});
    region_.borders.push_back(static_cast<std::uint32_t>(region_.names.size()));
    region_.names.push_back({facet_name(tile_, cell, k), to});
    region_.at_border.push_back(cut::Decided::no);
  }

  SurfaceTile& tile_;
  const Energy& energy_;
  const CutRule& rule_;
  BigVector<std::uint32_t> number_;  // by cell of the tile: the cell in the graph
  CutRegion region_;
};

}  // namespace

Result<CutRegion> region_of(SurfaceTile& tile, const Energy& energy, const CutRule& rule,
                            std::span<const ArcRecord> arcs) {
  Builder builder(tile, energy, rule);
  BOOST_OUTCOME_TRYV(builder.add_own());
  for (const ArcRecord& arc : arcs) {
    BOOST_OUTCOME_TRYV(builder.add(arc));
  }
  return builder.take();
}

}  // namespace tessera::surface

#include <algorithm>
#include <string>
#include <tuple>
#include <utility>

#include "src/surface/region.h"

namespace tessera::surface {

namespace {

constexpr std::uint32_t nothing = ~std::uint32_t{0};

// One side of a border between two regions.
struct Side {
  std::array<PointId, 3> facet;
  std::uint32_t region = nothing, border = 0;  // nothing: the border leads to a region that is not joined
  std::uint32_t to = 0;
};

// By region and name: the other side of the border.
using Sides = std::vector<std::vector<Side>>;
Result<Sides> match(const std::vector<ReducedRegion>& regions,
                    const std::function<std::optional<std::uint32_t>(TileId)>& region_of) {
  std::vector<Side> sides;
  Sides others(regions.size());
  for (std::uint32_t r = 0; r < regions.size(); ++r) {
    const auto& names = regions[r].names;
    others[r].resize(names.size());
    for (std::uint32_t b = 0; b < names.size(); ++b)
      if (const auto to = region_of(names[b].to)) sides.push_back({names[b].facet, r, b, *to});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.facet, a.region, a.border) < std::tie(b.facet, b.region, b.border);
  });
  for (std::size_t i = 0; i < sides.size(); i += 2) {
    const Side& a = sides[i];
    const Side& b = i + 1 < sides.size() ? sides[i + 1] : a;
    if (b.facet != a.facet || a.region == b.region || a.to != b.region || b.to != a.region)
      return error(Errc::corrupt, "there is a border at vertex " + to_string(a.facet[0]) + " towards tile " +
                                      to_string(regions[a.region].names[a.border].to) +
                                      " that its neighbour does not have");
    others[a.region][a.border] = b;
    others[b.region][b.border] = a;
  }
  return others;
}

class Joining {
 public:
  Joining(std::vector<ReducedRegion>& regions, Sides others) : regions_(regions), others_(std::move(others)) {}

  Result<JoinedRegion> run() {
    for (std::size_t r = 0; r < regions_.size(); ++r) {
      take_decided(r);
      number_names(r);
      out_.first.push_back(static_cast<std::uint32_t>(cells_));
      cells_ += regions_[r].kernel.graph.cells();
      if (cells_ > cut::cells_max)
        return error(Errc::memory, "the tiles leave more cells undecided than fit into one cut");
      number_arcs(r);
    }
    cut::CutGraph& graph = out_.region.graph;
    graph.excess.reserve(cells_);
    graph.capacity.reserve(4 * cells_);
    graph.back.reserve(4 * cells_);
    for (std::size_t r = 0; r < regions_.size(); ++r) add(r);
    return std::move(out_);
  }

 private:
  // Takes over what the joined regions beside it have decided. Borders of the joined region stay as they are.
  void take_decided(std::size_t r) {
    std::vector<cut::Decided> across;
    for (const std::uint32_t name : regions_[r].kernel.borders) {
      const Side& other = others_[r][name];
      across.push_back(other.region == nothing ? cut::Decided::no : regions_[other.region].at_border[other.border]);
    }
    cut::take_decided(regions_[r].kernel, across);
  }

  // Numbers the names of borders of the joined region.
  void number_names(std::size_t r) {
    const ReducedRegion& region = regions_[r];
    auto& number = name_of_.emplace_back(region.names.size(), nothing);
    for (std::size_t n = 0; n < region.names.size(); ++n) {
      if (others_[r][n].region != nothing) continue;
      number[n] = static_cast<std::uint32_t>(out_.region.names.size());
      out_.region.names.push_back(region.names[n]);
      out_.region.at_border.push_back(region.at_border[n]);
    }
  }

  // Numbers the arcs of borders in the joined region, by name.
  void number_arcs(std::size_t r) {
    const cut::ReducedGraph& kernel = regions_[r].kernel;
    auto& arcs = arc_of_.emplace_back(regions_[r].names.size(), cut::no_arc);
    for (std::size_t i = 0; i < kernel.borders.size(); ++i)
      arcs[kernel.borders[i]] = 4 * out_.first[r] + kernel.graph.borders[i].arc;
  }

  void add(std::size_t r) {
    cut::ReducedGraph& kernel = regions_[r].kernel;
    cut::CutGraph& graph = kernel.graph;
    cut::CutGraph& whole = out_.region.graph;
    whole.excess.insert(whole.excess.end(), graph.excess.begin(), graph.excess.end());
    whole.capacity.insert(whole.capacity.end(), graph.capacity.begin(), graph.capacity.end());
    for (const cut::Arc back : graph.back) {
      if (back == cut::no_arc) {
        whole.back.push_back(back);
      } else if (cut::is_inner(back)) {
        whole.back.push_back(back + 4 * out_.first[r]);
      } else {
        add_border(r, back & ~cut::border_bit);
      }
    }
    graph = {};
    kernel.cells = {};
  }

  void add_border(std::size_t r, std::uint32_t border) {
    const cut::ReducedGraph& kernel = regions_[r].kernel;
    cut::CutGraph& whole = out_.region.graph;
    const std::uint32_t name = kernel.borders[border];
    const Side& other = others_[r][name];
    if (other.region != nothing) {
      whole.back.push_back(arc_of_[other.region][other.border]);
      return;
    }
    whole.back.push_back(cut::border_bit | static_cast<std::uint32_t>(whole.borders.size()));
    whole.borders.push_back({arc_of_[r][name], kernel.graph.borders[border].capacity_in});
    out_.region.borders.push_back(name_of_[r][name]);
  }

  std::vector<ReducedRegion>& regions_;
  Sides others_;
  std::vector<std::vector<std::uint32_t>> name_of_;  // by region and name: the name in the joined region, or nothing
  // likewise: the arc in the joined region; no_arc where the cell is decided
  std::vector<std::vector<cut::Arc>> arc_of_;
  std::size_t cells_ = 0;
  JoinedRegion out_;
};

}  // namespace

Result<JoinedRegion> join(std::vector<ReducedRegion>& regions,
                          const std::function<std::optional<std::uint32_t>(TileId)>& region_of) {
  BOOST_OUTCOME_TRY(others, match(regions, region_of));
  return Joining(regions, std::move(others)).run();
}

}  // namespace tessera::surface

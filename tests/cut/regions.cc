#include "tests/cut/regions.h"

#include <algorithm>
#include <set>
#include <utility>

#include "src/cut/reduce.h"
#include "src/cut/search_trees.h"

namespace tessera::cut {

Split split(const WholeGraph& whole, const std::vector<std::uint32_t>& region_of, std::uint32_t regions) {
  Split made;
  made.graphs.resize(regions);
  made.cells.resize(regions);
  made.across.resize(regions);
  std::vector<std::uint32_t> number(whole.cells());
  for (std::uint32_t cell = 0; cell < whole.cells(); ++cell) {
    auto& cells = made.cells[region_of[cell]];
    number[cell] = static_cast<std::uint32_t>(cells.size());
    cells.push_back(cell);
  }
  for (std::uint32_t cell = 0; cell < whole.cells(); ++cell) {
    CutGraph& graph = made.graphs[region_of[cell]];
    graph.excess.push_back(whole.excess[cell]);
    for (const auto& side : whole.sides[cell]) {
      graph.capacity.push_back(side.capacity);
      const bool inner = side.cell != WholeGraph::nobody && region_of[side.cell] == region_of[cell];
      graph.back.push_back(inner ? 4 * number[side.cell] + side.facet : no_arc);
    }
  }
  for (std::uint32_t cell = 0; cell < whole.cells(); ++cell)
    for (std::uint32_t facet = 0; facet < 4; ++facet) {
      const auto& side = whole.sides[cell][facet];
      if (side.cell == WholeGraph::nobody || side.cell < cell || region_of[side.cell] == region_of[cell]) continue;
      const auto border = [&](std::uint32_t at, std::uint32_t f, std::uint32_t in) {
        CutGraph& graph = made.graphs[region_of[at]];
        const Arc arc = 4 * number[at] + f;
        graph.back[arc] = border_bit | static_cast<Arc>(graph.borders.size());
        graph.borders.push_back({arc, in});
        return Place{region_of[at], static_cast<std::uint32_t>(graph.borders.size() - 1)};
      };
      const Place here = border(cell, facet, whole.sides[side.cell][side.facet].capacity);
      const Place there = border(side.cell, side.facet, side.capacity);
      made.across[here.region].push_back(there);
      made.across[there.region].push_back(here);
    }
  return made;
}

void reduce(Split& split, std::vector<bool>& source) {
  const auto regions = static_cast<std::uint32_t>(split.graphs.size());
  for (bool more = true; more;) {
    more = false;
    for (std::uint32_t r = 0; r < regions; ++r) {
      CutGraph& graph = split.graphs[r];
      const CellSet flown = SearchTrees(graph).run();
      CutGraph least = with_borders_to_sink(graph), most = with_borders_from_source(graph);
      const CellSet sources = SearchTrees(least).run(), no_sinks = SearchTrees(most).run();
      const auto decided =
          graph.borders.empty() ? decided_by(flown, graph.cells()) : decided_by(sources, no_sinks, graph.cells());
      if (std::ranges::count(decided, Decided::no) == std::ranges::ssize(decided)) continue;
      more = true;
      for (std::uint32_t cell = 0; cell < graph.cells(); ++cell)
        if (decided[cell] == Decided::source) source[split.cells[r][cell]] = true;
      // What the others hear of their borders to here.
      std::vector<std::vector<Decided>> told(regions);
      for (std::uint32_t other = 0; other < regions; ++other)
        told[other].assign(split.graphs[other].borders.size(), Decided::no);
      for (std::uint32_t i = 0; i < graph.borders.size(); ++i) {
        const Place there = split.across[r][i];
        told[there.region][there.number] = decided[graph.borders[i].arc >> 2u];
      }
      CutKernel kernel = kernel_of(graph, decided);
      std::vector<std::uint32_t> cells;
      for (const std::uint32_t cell : kernel.cells) cells.push_back(split.cells[r][cell]);
      split.cells[r] = std::move(cells);
      graph = kernel.graph;
      std::vector<std::vector<Place>> across = split.across;
      across[r].clear();
      for (const std::uint32_t i : kernel.borders) across[r].push_back(split.across[r][i]);
      for (std::uint32_t other = 0; other < regions; ++other) {
        if (other == r) continue;
        CutKernel rest;
        rest.graph = std::move(split.graphs[other]);
        for (std::uint32_t i = 0; i < rest.graph.borders.size(); ++i) rest.borders.push_back(i);
        take_decided(rest, told[other]);
        split.graphs[other] = std::move(rest.graph);
        across[other].clear();
        for (const std::uint32_t i : rest.borders) across[other].push_back(split.across[other][i]);
      }
      // Of two regions the borders stand in the same order on both sides.
      for (std::uint32_t a = 0; a < regions; ++a) {
        std::vector<std::uint32_t> next(regions, 0);  // by other region: the first of its borders not met yet
        split.across[a].clear();
        for (const Place& place : across[a]) {
          const auto& theirs = across[place.region];
          std::uint32_t& number = next[place.region];
          while (theirs[number].region != a) ++number;
          split.across[a].push_back({place.region, number++});
        }
      }
    }
  }
}

namespace {

class Network {
 public:
  Network(const Split& split, std::uint32_t cells, const NetworkOptions& options, std::mt19937_64& random)
      : split_(split),
        cells_(cells),
        options_(options),
        random_(random),
        bound_(options.bound),
        crashes_(options.crashes) {
    regions_.resize(split.graphs.size());
    for (std::uint32_t r = 0; r < regions_.size(); ++r) begin(r);
  }

  std::optional<CutFound> run() {
    while (true) {
      if (!exchange()) return std::nullopt;
      if (options_.mutant == Mutant::labels_are_the_answer) return by_labels();
      const bool proved = flood();
      if (proved || options_.mutant == Mutant::no_flood) return std::move(found_);
      if (found_.floods > 60) return std::nullopt;
      if (options_.mutant != Mutant::fixed_bound) bound_ *= 2;
      for (std::uint32_t r = 0; r < regions_.size(); ++r) {
        regions_[r].discharge->set_bound(bound_);
        active_.insert(r);
      }
    }
  }

 private:
  struct Region {
    std::unique_ptr<CutGraph> graph;
    std::unique_ptr<Discharge> discharge;
    std::vector<std::uint32_t> labels;    // by border, as told last
    std::vector<Discharge::News> newest;  // by border
  };
  struct Mail {
    Place to;
    Discharge::News news;
    std::uint32_t epoch = 0;
  };

  void begin(std::uint32_t r) {
    Region& region = regions_[r];
    region.graph = std::make_unique<CutGraph>(split_.graphs[r]);
    region.discharge = std::make_unique<Discharge>(*region.graph, bound_);
    region.labels.assign(region.graph->borders.size(), 0);
    active_.insert(r);
  }

  // Some of the regions are lost, and what was on its way from and to them; all hear of it.
  void crash() {
    std::set<std::uint32_t> dead;
    const std::uint64_t count = 1 + random_() % (regions_.size() - 1);
    while (dead.size() < count) dead.insert(static_cast<std::uint32_t>(random_() % regions_.size()));
    ++epoch_;
    if (options_.mutant != Mutant::old_mail)
      std::erase_if(mail_, [&](const Mail& m) {
        return dead.contains(m.to.region) || dead.contains(split_.across[m.to.region][m.to.number].region);
      });
    for (const std::uint32_t r : dead) begin(r);
    for (const std::uint32_t r : dead)
      for (std::uint32_t i = 0; i < split_.across[r].size(); ++i) {
        const Place there = split_.across[r][i];
        if (dead.contains(there.region)) continue;
        const Discharge& other = *regions_[there.region].discharge;
        regions_[r].discharge->restore(i, other.received(there.number), other.sent(there.number));
      }
    for (std::uint32_t r = 0; r < regions_.size(); ++r) {
      regions_[r].discharge->forget_labels();
      std::ranges::fill(regions_[r].labels, 0u);
      active_.insert(r);
    }
    for (Mail& m : mail_) m.news.label = 0;  // what is on its way was said with the labels of before
  }

  bool exchange() {
    for (std::uint32_t steps = 0; !active_.empty() || !mail_.empty(); ++steps) {
      if (steps > 20'000) return false;
      if (crashes_ > 0 && regions_.size() > 1 && random_() % 20 == 0) {
        --crashes_;
        crash();
      } else if (!mail_.empty() && (active_.empty() || random_() % 2 == 0)) {
        deliver();
      } else {
        discharge();
      }
    }
    return true;
  }

  void deliver() {
    const auto at = mail_.begin() + static_cast<std::ptrdiff_t>(random_() % mail_.size());
    const Mail mail = *at;
    if (random_() % 5 != 0) mail_.erase(at);  // else it comes again
    Region& region = regions_[mail.to.region];
    Discharge::News news = mail.news;
    if (options_.mutant == Mutant::last_heard && news.sent < region.discharge->received(mail.to.number)) {
      // The counter goes back, and so does the excess.
      const Arc arc = region.graph->borders[mail.to.number].arc;
      const auto less = static_cast<std::uint32_t>(region.discharge->received(mail.to.number) - news.sent);
      region.graph->excess[arc >> 2u] -= less;
      active_.insert(mail.to.region);
    }
    news.border = mail.to.number;
    if (region.discharge->receive(news)) active_.insert(mail.to.region);
  }

  void discharge() {
    auto at = active_.begin();
    std::advance(at, static_cast<std::ptrdiff_t>(random_() % active_.size()));
    const std::uint32_t r = *at;
    active_.erase(at);
    ++found_.discharges;
    for (const Discharge::News& news : regions_[r].discharge->run()) {
      regions_[r].labels[news.border] = news.label;
      mail_.push_back({split_.across[r][news.border], news, epoch_});
    }
  }

  bool flood() {
    ++found_.floods;
    std::vector<Flood> floods;
    for (const Region& region : regions_) floods.emplace_back(*region.graph);
    for (bool more = true; more;) {
      more = false;
      for (std::uint32_t r = 0; r < floods.size(); ++r)
        for (const std::uint32_t border : floods[r].run()) {
          const Place there = split_.across[r][border];
          floods[there.region].enter(there.number);
          more = true;
        }
    }
    found_.source.assign(cells_, false);
    bool met = false;
    for (std::uint32_t r = 0; r < floods.size(); ++r) {
      met |= floods[r].met_deficit();
      for (std::uint32_t cell = 0; cell < split_.cells[r].size(); ++cell)
        if (floods[r].reached().contains(cell)) found_.source[split_.cells[r][cell]] = true;
    }
    return !met;
  }

  // As if a cell from which no deficit is known to be reached were the source's. Cells inside have no label: those are
  // asked that a border cell can reach.
  std::optional<CutFound> by_labels() {
    found_.source.assign(cells_, false);
    for (std::uint32_t r = 0; r < regions_.size(); ++r) {
      const CutGraph& graph = *regions_[r].graph;
      CellSet source = reached_from_excess(graph);
      for (std::uint32_t i = 0; i < graph.borders.size(); ++i)
        if (regions_[r].labels[i] >= bound_) source.insert(graph.borders[i].arc >> 2u);
      for (std::uint32_t cell = 0; cell < split_.cells[r].size(); ++cell)
        found_.source[split_.cells[r][cell]] = source.contains(cell);
    }
    return std::move(found_);
  }

  const Split& split_;
  std::uint32_t cells_;
  NetworkOptions options_;
  std::mt19937_64& random_;
  std::uint32_t bound_, crashes_, epoch_ = 0;
  std::vector<Region> regions_;
  std::vector<Mail> mail_;
  std::set<std::uint32_t> active_;
  CutFound found_;
};

}  // namespace

std::optional<CutFound> run_regions(const Split& split, std::uint32_t cells, const NetworkOptions& options,
                                    std::mt19937_64& random) {
  return Network(split, cells, options, random).run();
}

}  // namespace tessera::cut

// Small graphs of degree 4, and their smallest minimum cut by trying all source sets.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "src/surface/cut/cut_graph.h"

namespace tessera::cut {

struct WholeGraph {
  static constexpr std::uint32_t nobody = ~std::uint32_t{0};
  struct Side {
    std::uint32_t cell = nobody, facet = 0;  // across the facet
    std::uint32_t capacity = 0;              // to there
  };
  std::vector<std::int64_t> excess;
  std::vector<std::array<Side, 4>> sides;

  std::uint32_t cells() const { return static_cast<std::uint32_t>(excess.size()); }
  // False when one of them has four neighbours already.
  bool join(std::uint32_t a, std::uint32_t b, std::uint32_t there, std::uint32_t back);
  CutGraph as_one() const;
};

// `cells`: up to 20 for what follows.
WholeGraph random_graph(std::mt19937_64& random, std::uint32_t cells);
// Cells on a grid, each joined to its neighbours in two axes.
WholeGraph grid_graph(std::mt19937_64& random, std::uint32_t width, std::uint32_t height);

// What a source set costs: deficits in it, excess outside of it, capacities out of it.
std::int64_t cost(const WholeGraph& graph, const std::vector<bool>& source);
// The cells that all minimum cuts have on the source's side.
std::vector<bool> smallest_by_trying(const WholeGraph& graph);
// The same by augmenting along shortest ways, one after the other.
std::vector<bool> smallest_by_augmenting(const WholeGraph& graph);

std::vector<bool> as_bools(const CellSet& set, std::uint32_t cells);

}  // namespace tessera::cut

// Which cells residual arcs lead to from all excess, over many regions: when all is quiet, the smallest minimum cut, if
// no deficit was met; so whatever has moved the flow before, a flood proves the cut or shows that there is more to do.
#pragma once

#include <cstdint>
#include <vector>

#include "src/cut/cut_graph.h"

namespace tessera::cut {

class Flood {
 public:
  // `graph` outlives this, and does not change meanwhile.
  explicit Flood(const CutGraph& graph);

  // A cell across this border was reached, and its arc to here has capacity left.
  void enter(std::uint32_t border);
  // Goes on as far as it can inside; then the borders that were crossed since the last call.
  std::vector<std::uint32_t> run();

  bool met_deficit() const { return met_deficit_; }
  const CellSet& reached() const { return reached_; }

 private:
  void reach(std::uint32_t cell);

  const CutGraph& graph_;
  CellSet reached_;
  std::vector<std::uint32_t> queue_;
  bool met_deficit_ = false;
};

}  // namespace tessera::cut

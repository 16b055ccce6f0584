#include "src/surface/cut/certificate.h"

#include <algorithm>
#include <vector>

namespace tessera::cut {

namespace {

// Returns what has flowed into a cell less what has flowed out, by the capacities of its arcs inside the region. 64
// bits hold the sum of four arcs.
std::int64_t gained(const CutGraph& before, const CutGraph& after, std::uint32_t cell) {
  std::int64_t sum = 0;
  for (Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc)
    sum += static_cast<std::int64_t>(after.capacity[arc]) - static_cast<std::int64_t>(before.capacity[arc]);
  return sum;
}

}  // namespace

std::string why_no_proof(const CutGraph& before, const CutGraph& after, const CellSet& source) {
  if (before.cells() != after.cells() || before.capacity.size() != after.capacity.size() ||
      !std::equal(before.back.begin(), before.back.end(), after.back.begin(), after.back.end()))
    return "the flow belongs to another graph";
  for (Arc arc = 0; arc < before.capacity.size(); ++arc) {
    const Arc back = before.back[arc];
    if (!is_inner(back)) {
      if (before.capacity[arc] != after.capacity[arc]) return "flow has left the region at arc " + std::to_string(arc);
      continue;
    }
    const auto sum = [&](const CutGraph& graph) { return std::uint64_t{graph.capacity[arc]} + graph.capacity[back]; };
    if (sum(before) != sum(after)) return "the flow does not keep to the capacity of arc " + std::to_string(arc);
  }
  std::vector<std::uint32_t> reached;
  CellSet seen(after.cells());
  for (std::uint32_t cell = 0; cell < after.cells(); ++cell) {
    if (after.excess[cell] - before.excess[cell] != gained(before, after, cell))
      return "flow is lost or created at cell " + std::to_string(cell);
    if (source.contains(cell) ? after.excess[cell] < 0 : after.excess[cell] > 0)
      return "cell " + std::to_string(cell) + " keeps flow on the wrong side";
    if (after.excess[cell] <= 0) continue;
    seen.insert(cell);
    reached.push_back(cell);
  }
  while (!reached.empty()) {
    const std::uint32_t cell = reached.back();
    reached.pop_back();
    for (Arc arc = 4 * cell; arc < 4 * cell + 4; ++arc) {
      const Arc back = after.back[arc];
      if (!is_inner(back) || after.capacity[arc] == 0) continue;
      if (!source.contains(back >> 2u)) return "more flow is possible from cell " + std::to_string(cell);
      if (seen.insert(back >> 2u)) reached.push_back(back >> 2u);
    }
  }
  if (seen != source) return "the source's side is not the smallest";
  return {};
}

}  // namespace tessera::cut

#include "src/result/terrain/link_pieces.h"

#include <algorithm>
#include <tuple>

namespace tessera::terrain {

Status link_pieces(std::vector<Piece>& pieces,
                   const std::function<Status(std::int64_t, const std::vector<TileEdge>&)>& give) {
  const auto before = [](const Piece& a, const Piece& b) {
    return std::tie(a.level, a.from) < std::tie(b.level, b.from);
  };
  std::sort(pieces.begin(), pieces.end(), before);
  constexpr std::size_t none = ~std::size_t{0};
  std::vector<std::size_t> next(pieces.size(), none);
  std::vector<bool> goes_on(pieces.size()), used(pieces.size());
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece wanted{pieces[i].level, pieces[i].to, {}};
    const auto found = std::lower_bound(pieces.begin(), pieces.end(), wanted, before);
    if (found == pieces.end() || before(wanted, *found)) continue;
    next[i] = static_cast<std::size_t>(found - pieces.begin());
    goes_on[next[i]] = true;
  }
  std::vector<TileEdge> edges;
  // First the open lines, then the closed ones.
  for (const bool closed : {false, true}) {
    for (std::size_t first = 0; first < pieces.size(); ++first) {
      if (used[first] || (!closed && goes_on[first])) continue;
      edges.assign(1, pieces[first].from);
      for (std::size_t i = first; i != none && !used[i]; i = next[i]) {
        used[i] = true;
        edges.push_back(pieces[i].to);
      }
      BOOST_OUTCOME_TRYV(give(pieces[first].level, edges));
    }
  }
  return success();
}

}  // namespace tessera::terrain

#include "src/tiling/tile/final_cells.h"

#include <algorithm>

namespace tessera {

FinalCells extract_final(const CellList& list, const std::vector<std::uint8_t>& open, int dimension) {
  const auto corners = static_cast<std::size_t>(dimension) + 1;
  std::vector<std::uint32_t> place(open.size(), FinalCells::open);
  std::uint32_t kept = 0;
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (!open[c]) place[c] = kept++;
  }
  FinalCells out;
  out.others = open.size() - kept;
  out.rows.reserve(kept);
  // Returns which facet of the cell `across` it has in common with c.
  const auto facet_of = [&](std::size_t across, std::size_t c) {
    const auto begin = list.neighbors.begin() + static_cast<std::ptrdiff_t>(across * corners);
    return static_cast<std::uint32_t>(std::find(begin, begin + static_cast<std::ptrdiff_t>(corners), c) - begin);
  };
  for (std::size_t c = 0; c < open.size(); ++c) {
    if (open[c]) continue;
    CellRecord row{};
    for (std::size_t i = 0; i < corners; ++i) {
      const std::uint32_t n = list.neighbors[c * corners + i];
      row.vertices[i] = list.vertices[c * corners + i];
      row.neighbors[i] = open[n] ? FinalCells::open : 4 * place[n] + facet_of(n, c);
    }
    out.rows.push_back(row);
  }
  return out;
}

RowsOfFrozen::RowsOfFrozen(const PendingFinals& finals) : finals_(finals) {
  if (finals.frozen.empty()) return;
  rows_.assign(std::size_t{finals.frozen.back()} + 1, static_cast<std::uint32_t>(finals.cells.rows.size()));
  for (std::uint32_t r = 0; r < finals.frozen.size(); ++r) rows_[finals.frozen[r]] = r;
}

std::size_t RowsOfFrozen::of(std::uint32_t number) const {
  const std::size_t end = finals_.cells.rows.size();
  if (finals_.frozen.empty()) return std::min<std::size_t>(number, end);
  return number < rows_.size() ? rows_[number] : end;
}

bool PendingFinals::sound(int dimension, std::uint64_t own) const {
  const std::size_t count = cells.rows.size();
  if (count + early > CellRecord::most || frozen.size() != mesh_index.size()) return false;
  if (mesh_index.empty() ? early > 0 && count > 0 : mesh_index.size() != count) return false;
  if (!frozen.empty() && frozen.back() >= CellRecord::most) return false;
  if (!std::is_sorted(frozen.begin(), frozen.end(), std::less_equal<>())) return false;
  std::vector<bool> taken(mesh_index.size());
  for (const std::uint32_t p : mesh_index) {
    if (p < early || p - early >= count || taken[p - early]) return false;
    taken[p - early] = true;
  }
  for (std::size_t c = 0; c < count; ++c) {
    for (int i = 0; i <= dimension; ++i) {
      const Vertex v = cells.rows[c].vertices[i];
      const std::uint32_t n = cells.rows[c].neighbors[i];
      if (v == infinite_vertex || v > own) return false;
      if (n != FinalCells::open && ((n & written) != 0 ? (n & ~written) >= early : n / 4 >= count)) return false;
    }
  }
  return true;
}

CellKey cell_key(const std::uint32_t* vertices, int dimension) {
  CellKey key{~0u, ~0u, ~0u, ~0u};
  std::copy_n(vertices, dimension + 1, key.begin());
  std::sort(key.begin(), key.end());
  return key;
}

}  // namespace tessera

// Finds the facets that belong to only one cell of an exported file.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "src/result/export/cell_filter.h"
#include "src/result/export/mesh_writer.h"
#include "src/result/store/external_sort.h"

namespace tessera::exports {

// Memory for facets; more facets are sorted on disk.
inline constexpr std::uint64_t facet_sort_bytes = std::uint64_t{64} << 20;

class Boundary {
 public:
  // Facets that do not fit into memory are sorted in `scratch`. REQUIRES: numbers of vertices are less than 2^32.
  Boundary(int dimension, std::filesystem::path scratch)
      : corners_(static_cast<std::size_t>(dimension) + 1), open_(std::move(scratch), facet_sort_bytes) {}

  // Adds those facets of a positively oriented cell that are not surely shared with another cell of its tile. REQUIRES:
  // number < 2^31.
  Status add(const CellView& cell, std::uint64_t number) {
    for (std::size_t k = 0; k < corners_; ++k) {
      if (cell.neighbors[k] >= 0) continue;
      Facet facet;
      std::array<Point, 3> places;
      for (std::size_t i = 0, at = 0; i < corners_; ++i) {
        if (i == k) continue;
        places[at] = cell.at[i];
        facet.vertices[at++] = static_cast<std::uint32_t>(cell.numbers[i]);
      }
      facet.longest_edge = exports::longest_edge(std::span(places).first(corners_ - 1), corners_ == 3);
      // Without vertex k, the other vertices in their order are seen from outside when k is even, in 2D and in 3D.
      facet.turned = k % 2 == 0 ? 0 : 1;
      facet.cell = static_cast<std::uint32_t>(number) & 0x7fff'ffffU;
      facet.sort(corners_ - 1);
      BOOST_OUTCOME_TRYV(open_.push(facet));
    }
    return success();
  }

  // Calls `visit(numbers, longest_edge, cell)` for each facet that belongs to one cell only. The order depends only on
  // the set of facets. `numbers` has `dimension` vertices: counterclockwise seen from outside in 3D, with the cell on
  // their left in 2D. The object cannot be used afterwards. Error corrupt for a facet of more than two cells.
  template <class Visit>
  Status for_each(Visit visit) {
    const auto same = [](const Facet& a, const Facet& b) { return a.vertices == b.vertices; };
    return for_each_group(open_, 3, same, [&](std::span<const Facet> cells) -> Status {
      if (cells.size() > 2) return error(Errc::corrupt, "a facet of the result belongs to more than two cells");
      if (cells.size() == 2) return success();
      auto vertices = cells[0].vertices;
      if (cells[0].turned != 0) std::swap(vertices[corners_ - 3], vertices[corners_ - 2]);
      visit(std::span<const std::uint32_t>(vertices).first(corners_ - 1), cells[0].longest_edge,
            std::uint64_t{cells[0].cell});
      return success();
    });
  }

 private:
  struct Facet {
    std::array<std::uint32_t, 3> vertices{};  // ascending
    std::uint32_t turned : 1 = 0;             // 1: an odd permutation of the outward order
    std::uint32_t cell : 31 = 0;
    double longest_edge = 0;  // in the plane in 2D
    void sort(std::size_t size) {
      for (std::size_t i = 1; i < size; ++i)
        for (std::size_t j = i; j > 0 && vertices[j] < vertices[j - 1]; --j) {
          std::swap(vertices[j], vertices[j - 1]);
          turned = turned == 0 ? 1 : 0;
        }
    }
    friend bool operator<(const Facet& a, const Facet& b) {
      return a.vertices != b.vertices ? a.vertices < b.vertices : a.turned < b.turned;
    }
  };
  std::size_t corners_;
  ExternalSort<Facet> open_;
};

}  // namespace tessera::exports

// Checks that the cells of a periodic result, with all their images, fill space once.
//
// S is the set of all images of all vertices. Let the cells be glued in pairs across all facets but hull facets, and be
// positively oriented (tile_check.h). Let B be the closed convex hull of S: all of space if there is a period along
// each axis, else the product of the axes with a period and of C, the convex hull of the vertices along the other axes.
// This class checks two facts, in exact arithmetic:
//  (1) Each hull facet lies in the border of B.
//  (2) The volumes of the main cells add up to the volume of the part of B that is one period long along each axis with
//      a period.
// Facets and their borders of less dimension do not separate the inside of B, and by (1) the number of cells over a
// place changes at no facet inside B. So that number is the same everywhere in B, outside of the borders of facets. No
// cell is outside of B, because all vertices are in B. The main cells are all cells, each once up to shifts. So by (2)
// that number is one. Then the Delaunay lemma holds as it does without periods: lifted to the paraboloid, the cells are
// convex at each facet, so along each line, so everywhere.
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <stop_token>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/store/external_sort.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

// An exact sum of volumes of cells, times d!.
class VolumeSum {
 public:
  using Exact = boost::multiprecision::cpp_rational;
  // `corners`: of a positively oriented cell, d+1 points.
  void add(std::span<const Point> corners);
  Exact value() const;

 private:
  // By exponent: the sum of numbers that are to be multiplied by 2^exponent. A summand of `few_` has less than 190
  // bits, so 2^60 of them have less than 256.
  std::map<int, boost::multiprecision::int256_t> few_;
  std::map<int, boost::multiprecision::cpp_int> many_;
};

class PeriodicSpace {
 public:
  PeriodicSpace(int dimension, const Period& period, TileSource source, const std::filesystem::path& scratch,
                std::uint64_t memory_bytes, std::stop_token stop);

  void add_vertex(const Point& own);
  void add_main_cell(std::span<const Point> corners) { volume_.add(corners); }
  // Adds a facet without a cell behind it: `dimension` points.
  Status add_hull_facet(std::span<const Point> corners, const CellRef& cell, const IdSet& ids);
  // Call this after all of them. Error not_delaunay.
  Status finish();
  std::uint64_t hull_facets() const { return hull_facets_; }

 private:
  // The coordinates along the axes without a period.
  struct Flat {
    double u = 0, v = 0;
    friend auto operator<=>(const Flat&, const Flat&) = default;
  };
  struct Facet {
    std::array<Flat, 3> at;
    CellRef cell;
    IdSet ids;
    friend bool operator<(const Facet& a, const Facet& b) {
      return a.cell.tile != b.cell.tile ? a.cell.tile < b.cell.tile : a.cell.cell < b.cell.cell;
    }
  };
  Flat flat(const Point& p) const;
  static int side(const Flat& a, const Flat& b, const Flat& c);
  // Leaves only the corners of the convex hull of flat_, counterclockwise.
  void shrink();
  bool in_border(const Facet& facet) const;
  // The measure of C, times the factorial of its dimension.
  VolumeSum::Exact measure() const;

  int dimension_;
  Period period_;
  TileSource source_;
  std::stop_token stop_;
  std::vector<int> open_;  // the axes without a period
  VolumeSum volume_;
  std::vector<Flat> flat_;
  std::size_t shrink_at_ = std::size_t{1} << 16;
  ExternalSort<Facet> facets_;
  std::uint64_t hull_facets_ = 0;
};

}  // namespace tessera

// The triangles of polygons, found by place.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "src/result/volume/box_tree.h"
#include "src/result/volume/overlay.h"
#include "src/result/volume/polygons.h"

namespace tessera::volume {

// A triangle of a polygon that a cell overlaps, and their common area.
struct OverlappedFacet {
  const Facet* facet = nullptr;
  std::uint32_t polygon = 0;
  double area = 0;
};

class PolygonIndex {
 public:
  // The polygons must stay where they are as long as this object.
  explicit PolygonIndex(const MapPolygons& polygons) {
    std::vector<FlatBox> boxes;
    for (std::size_t p = 0; p < polygons.polygons.size(); ++p) {
      for (const Facet& facet : polygons.polygons[p].facets) {
        facets_.push_back({&facet, static_cast<std::uint32_t>(p), 0});
        boxes.push_back(box_of(facet));
      }
    }
    tree_ = BoxTree(boxes);
  }

  // In an order that depends on the polygons alone.
  std::vector<OverlappedFacet> overlapped_by(const Facet& cell) const {
    std::vector<OverlappedFacet> found;
    tree_.for_each_near(box_of(cell), [&](std::uint32_t i) {
      OverlappedFacet one = facets_[i];
      one.area = common_area(cell, *one.facet);
      if (one.area > 0) found.push_back(one);
    });
    return found;
  }

 private:
  std::vector<OverlappedFacet> facets_;
  BoxTree tree_;
};

}  // namespace tessera::volume

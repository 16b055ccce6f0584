// Volumes between two surfaces: cut, fill, and what is not covered (docs/volumes.md).
//
// A is the surface before, B the surface after. Cut is the volume where A lies above B: material to take away to come
// from A to B. Fill is the volume where B lies above A: material to add.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "tessera/failure.h"
#include "tessera/surface_request.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

class VolumeRequest;
extern template class TESSERA_PUBLIC SurfaceRequest<VolumeRequest>;

// Options of compute_volumes() and write_difference_raster(). Every function returns *this.
class TESSERA_PUBLIC VolumeRequest : public SurfaceRequest<VolumeRequest> {
 public:
  VolumeRequest();

  // B is the level plane at this height. Only without a second triangulation.
  VolumeRequest& plane(double height);
  // B is spanned by the vertices of the polygons of this file, which have heights; each polygon is a row. Only without
  // a second triangulation. Files of polygons are GeoPackage, GeoJSON, FlatGeobuf or Shapefile.
  VolumeRequest& base(const std::filesystem::path& file);
  // A row for each polygon of this file: the volumes inside of the polygon. Default: one row for all.
  VolumeRequest& within(const std::filesystem::path& file);
  // The attribute that names the polygons. Default: "name" or "id", if there is one.
  VolumeRequest& name(const std::string& attribute);
  // 0, the default: all processors.
  VolumeRequest& threads(unsigned threads);
};

// Columns of n rows: a row for each polygon, in the order of the file, or one row. Volumes are those over the area that
// both surfaces cover. Programs are compiled with the size of this struct, so it never changes.
struct VolumeTable {
  std::vector<std::int64_t> polygons;  // the numbers of the polygons in their file; none without polygons
  std::vector<std::string> names;      // of the polygons
  std::vector<double> cut, fill, net;  // net: cut - fill
  std::vector<double> mean;            // of A - B over the covered area; NaN where nothing is covered
  std::vector<double> area;            // of the polygon; without polygons, of what A or B covers
  std::vector<double> covered;         // of it, by A and B
  std::vector<double> uncovered;       // the rest
  std::vector<double> uncovered_by_a, uncovered_by_b;
  std::string area_unit, volume_unit;  // "metre^2"; "" when unknown
  std::string note;                    // a sentence about the coordinate system, or ""
};

// Returns the volumes between two surfaces, or between a surface and the plane or base of the request. Every value is
// right to 1e-12 of cut + fill, or of the area, and has the same bits for all tiles and threads. Failure: usage for
// options that contradict each other and for a 3D result; bad_input for polygons that are not valid, and for
// coordinate systems that differ; corrupt, io, memory, interrupted.
TESSERA_PUBLIC VolumeTable compute_volumes(const Triangulation& a, const Triangulation& b,
                                           const VolumeRequest& request = {});
TESSERA_PUBLIC VolumeTable compute_volumes(const Triangulation& a, const VolumeRequest& request);
// Writes A - B at the centres of pixels of width `res` as a Cloud Optimized GeoTIFF: above 0 where A lies above B. A
// pixel has no value where one of the two surfaces has none. Failure: also usage if `target` exists or does not end in
// .tif.
TESSERA_PUBLIC void write_difference_raster(const Triangulation& a, const Triangulation& b,
                                            const std::filesystem::path& target, double res,
                                            const VolumeRequest& request = {});
TESSERA_PUBLIC void write_difference_raster(const Triangulation& a, const std::filesystem::path& target, double res,
                                            const VolumeRequest& request);

}  // namespace tessera

// The volumes between two surfaces over the plane: cut, fill, and what is not covered.
//
// A is the surface before, B the surface after. Where B lies below A, material is taken away: cut. Where B lies above
// A, material is added: fill. Volumes are computed over the area that both surfaces cover, exactly on the triangles
// (overlay.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/result.h"

namespace tessera {

struct VolumeOptions {
  // What B is, if it is no result; one of both.
  std::optional<double> plane = {};  // the level plane at this height
  std::filesystem::path base = {};   // a file of polygons whose vertices have heights; each polygon is a row
  // A file of polygons that limit the volumes, a row each; else there is one row.
  std::filesystem::path within = {};
  std::string name = {};                  // the attribute that names polygons; empty: "name" or "id", if there is one
  std::optional<double> max_edge = {};    // cells with a longer edge in the plane are not part of a surface
  std::optional<double> max_radius = {};  // and cells with a larger circumradius
  std::string value = "z";                // the attribute of the vertices that has the heights
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // at least the memory of one tile of each surface is used
  unsigned threads = 1;
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

// The volumes in one polygon, or all. Areas are in the plane.
struct VolumeRow {
  std::optional<std::int64_t> feature = {};  // the number of the polygon in its file
  std::string name = {};                     // of the polygon
  double cut = 0;                            // the volume between the surfaces where A lies above B
  double fill = 0;                           // ... where B lies above A
  double net = 0;                            // cut - fill: the integral of A - B
  double mean = 0;                           // of A - B over the covered area; NaN if there is none
  double area = 0;                           // of the polygon; without polygons, of what A or B covers
  double covered = 0;                        // of it, by both surfaces
  double uncovered = 0;                      // the rest
  double uncovered_by_a = 0, uncovered_by_b = 0;
  std::vector<std::byte> wkb = {};  // the polygon
};

struct Volumes {
  std::vector<VolumeRow> rows;         // in the order of the polygons in their file
  bool polygons = false;               // a row is a polygon
  std::string crs;                     // of the surfaces, as a manifest has it
  std::string area_unit, volume_unit;  // "metre^2"; "" when unknown
  std::uint64_t long_edges = 0;        // cells that were read and left out because of their edges
  std::uint64_t without_height = 0;    // ... because a vertex has no finite height
  std::string note;                    // remarks about the surfaces; else empty
};

// Error usage for options that contradict each other; `second`: B is a result.
Status check_volume_options(bool second, const VolumeOptions& options);
// Error bad_input when the coordinates of two results surely have different systems.
Status check_same_system(const std::filesystem::path& a, const std::string& crs_of_a, const std::filesystem::path& b,
                         const std::string& crs_of_b);

// `b` is the result that is the surface B, if it is one. Every value is right to 1e-12 of cut + fill, or of the area;
// areas that are uncovered and smaller than that are 0. The values have the same bits however the results are tiled,
// and for any number of threads. Errors, before anything is computed: usage for options that contradict each other, a
// 3D result, or a missing attribute; those of read_polygons(); bad_input when the two surfaces, or the polygons, have
// other coordinate systems. Then: corrupt, io, memory, interrupted.
Result<Volumes> volumes(const std::filesystem::path& a, const std::optional<std::filesystem::path>& b,
                        const VolumeOptions& options, std::stop_token stop);

}  // namespace tessera

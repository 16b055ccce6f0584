#include "src/verify/verify.h"

#include <algorithm>
#include <optional>
#include <system_error>

#include "src/store/checksum.h"
#include "src/verify/against_cgal.h"
#include "src/verify/cell_copies.h"
#include "src/verify/hull.h"
#include "src/verify/match_facets.h"
#include "src/verify/tile_check.h"
#include "src/verify/vertex_ids.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

Status check_sum(const fs::path& path, std::uint64_t expected) {
  BOOST_OUTCOME_TRY(sum, checksum_file(path));
  if (sum == expected) return success();
  return error(Errc::corrupt, path.string() + ": its checksum is " + checksum_text(sum) + ", the manifest says " +
                                  checksum_text(expected) + ": the file was changed or damaged");
}

// The file is what the manifest says, and only then parsed.
Result<TileMesh> open_tile(const fs::path& out, const TileEntry& entry, const Manifest& manifest) {
  const auto path = tile_file(out, TileId{entry.tile});
  BOOST_OUTCOME_TRYV(check_sum(path, entry.xxh3));
  BOOST_OUTCOME_TRY(tile, read_tile(out, TileId{entry.tile}));
  TileMesh& mesh = tile.mesh;
  const auto count = [](const auto& ghosts) {
    return static_cast<std::uint64_t>(std::count(ghosts.begin(), ghosts.end(), 0));
  };
  if (mesh.dimension != manifest.dimension)
    return error(Errc::corrupt, path.string() + ": has another dimension than the manifest");
  if (mesh.points.size() != entry.points || count(mesh.point_ghost) != entry.own_points ||
      mesh.cell_ghost.size() != entry.cells || count(mesh.cell_ghost) != entry.main_cells)
    return error(Errc::corrupt, path.string() + ": holds other numbers of vertices or cells than the manifest says");
  if (mesh.neighbors.empty() && entry.cells > 0 && manifest.neighbors)
    return error(Errc::corrupt, path.string() + ": has no neighbours, though the manifest says so");
  if (entry.tile < manifest.boxes.size()) {
    const Box& box = manifest.boxes[entry.tile];
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.point_ghost[i] == 0 && !box.contains(mesh.points[i]))
        return error(Errc::not_delaunay,
                     path.string() + ": own vertex " + std::to_string(mesh.ids[i]) + " lies outside the tile's box");
  }
  return std::move(mesh);
}

std::uint64_t largest_tile(const Manifest& manifest) {
  std::uint64_t bytes = 0;
  for (const auto& entry : manifest.tiles) bytes = std::max(bytes, entry.bytes);
  return bytes;
}

}  // namespace

Result<VerifyReport> verify(const fs::path& out, const VerifyOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRY(manifest, read_manifest(out));
  VerifyReport report;
  BOOST_OUTCOME_TRYV(check_sum(out / "triangulation.vtkhdf", manifest.master_xxh3));
  if (manifest.duplicates_xxh3 != 0) {
    BOOST_OUTCOME_TRYV(check_sum(out / "duplicates.bin", manifest.duplicates_xxh3));
  }

  fs::path scratch = options.scratch;
  if (scratch.empty()) {
    std::error_code code;
    scratch = fs::temp_directory_path(code);
    if (code) return error(Errc::io, "no temporary folder is set: " + code.message());
  }
  // A tile is in memory once, and its facets when neighbours must be found; the four sorters share the rest.
  const std::uint64_t tile_bytes = largest_tile(manifest) * (manifest.neighbors ? 1 : 3);
  const std::uint64_t rest = options.memory_bytes > tile_bytes ? options.memory_bytes - tile_bytes : 0;
  const std::uint64_t share = std::max<std::uint64_t>(rest / 5, std::uint64_t{1} << 20);
  ExternalSort<CellCopy> copies(scratch, share);
  ExternalSort<OwnVertex> own(scratch, share);
  ExternalSort<FacetClaim> claims(scratch, share);
  Hull hull(manifest.dimension, out, scratch, share);
  std::optional<AgainstCgal> cgal;
  if (options.against_cgal) cgal.emplace(manifest.dimension);

  TileSinks sinks{copies, own, claims, hull};
  for (const auto& entry : manifest.tiles) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while verifying");
    BOOST_OUTCOME_TRY(mesh, open_tile(out, entry, manifest));
    const bool neighbors_stored = !mesh.neighbors.empty();
    if (!neighbors_stored) {
      BOOST_OUTCOME_TRYV(match_facets(mesh, entry.tile, out));
    }
    BOOST_OUTCOME_TRYV(check_tile(mesh, entry.tile, neighbors_stored, out, sinks, stop));
    if (cgal) cgal->add(mesh);
    report.cells += entry.main_cells;
    report.vertices += entry.own_points;
  }
  BOOST_OUTCOME_TRY(duplicates, read_duplicates(out));
  BOOST_OUTCOME_TRYV(check_vertex_ids(own, manifest, std::move(duplicates), out));
  BOOST_OUTCOME_TRYV(check_cell_copies(copies, manifest.dimension, out));
  BOOST_OUTCOME_TRYV(check_claims(claims, out));
  BOOST_OUTCOME_TRYV(hull.finish());
  if (report.cells != manifest.cells)
    return error(Errc::not_delaunay, (out / "manifest.json").string() + ": counts " + std::to_string(manifest.cells) +
                                         " cells, the tiles have " + std::to_string(report.cells) + " main ones");
  if (report.cells == 0) return error(Errc::not_delaunay, out.string() + ": holds no cell");
  report.facets = sinks.facets;
  report.hull_facets = hull.facets();

  report.passed = {
      "checksums of all files",
      "vertices = points - duplicates - rejects; every vertex is one tile's own, with the same coordinates everywhere",
      "every cell is main in exactly one tile, and present where its vertices are",
      "every cell is positively oriented",
      manifest.neighbors ? "every facet is shared by two cells that name each other, or is on the hull"
                         : "every facet is shared by two cells, or is on the hull",
      "every facet inside is locally Delaunay, exactly, with the perturbation's tie rule",
      "the hull is closed, convex and winds around its inside once",
  };
  if (cgal) {
    BOOST_OUTCOME_TRYV(cgal->compare(out));
    report.passed.emplace_back("the set of cells equals that of CGAL's triangulation of all vertices");
  }
  return report;
}

}  // namespace tessera

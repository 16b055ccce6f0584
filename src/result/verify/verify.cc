#include "src/result/verify/verify.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "src/base/files/names.h"
#include "src/base/files/temporary.h"
#include "src/result/store/period.h"
#include "src/result/verify/against_cgal.h"
#include "src/result/verify/boxes.h"
#include "src/result/verify/cell_copies.h"
#include "src/result/verify/hull.h"
#include "src/result/verify/match_facets.h"
#include "src/result/verify/owners.h"
#include "src/result/verify/periodic_space.h"
#include "src/result/verify/result_files.h"
#include "src/result/verify/tile_check.h"
#include "src/result/verify/vertex_ids.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

// What the tiles contain, for comparison with the manifest.
struct Contents {
  Bounds bounds;
  std::vector<Digest> digests;  // by index in manifest.tiles
  void add(const TileMesh& mesh) {
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
      if (mesh.point_ghost[i] == 0) bounds.add(mesh.points[i]);
    digests.push_back(digest_of(mesh));
  }
};

// Results of older programs have no digests, and then nothing can be compared. But no digest may be missing beside
// others.
Status check_contents(const Contents& contents, const TileSource& source) {
  const Manifest& manifest = source.manifest();
  const auto place = manifest_file(source.folder()).string();
  if (contents.bounds != manifest.bounds)
    return error(Errc::corrupt, place + ": its bounds are not those of the vertices");
  Digest sum;
  const bool all = std::all_of(manifest.tiles.begin(), manifest.tiles.end(), [](const auto& e) { return e.digest; });
  const bool none = std::none_of(manifest.tiles.begin(), manifest.tiles.end(), [](const auto& e) { return e.digest; });
  if (!all && !none) return error(Errc::corrupt, place + ": some of its tiles have a digest, and others have none");
  if (manifest.digest.has_value() != all)
    return error(Errc::corrupt, place + (all ? ": has no digest, though all of its tiles have one"
                                             : ": has a digest, though none of its tiles has one"));
  for (std::size_t i = 0; i < manifest.tiles.size(); ++i) {
    const TileEntry& entry = manifest.tiles[i];
    sum += contents.digests[i];
    if (entry.digest && *entry.digest != contents.digests[i])
      return error(Errc::corrupt, source.file(i).string() + ": its digest is " + digest_text(contents.digests[i]) +
                                      ", but the manifest says " + digest_text(*entry.digest) +
                                      ": it holds another triangulation than was stored");
  }
  if (manifest.digest && *manifest.digest != sum)
    return error(Errc::corrupt, place + ": its digest " + digest_text(*manifest.digest) +
                                    " is not the sum of the tiles', " + digest_text(sum));
  return success();
}

std::uint64_t largest_tile(const TileSource& source) {
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < source.tiles(); ++i) bytes = std::max(bytes, source.work_bytes(i));
  return bytes;
}

// What a result that has come through all checks is proved to be, a line each.
std::vector<std::string> proved(const Manifest& manifest) {
  std::vector<std::string> lines{
      "checksums of all files; the master file leads to these tiles, and there are no others",
      "vertices = points - duplicates - rejects; every vertex is one tile's own, with the same coordinates everywhere",
      "every cell is main in exactly one tile, and present where its vertices are",
      "every cell is positively oriented",
      period_of(manifest).any() && period_of(manifest).open_axes(manifest.dimension) == 0
          ? "every facet is shared by two cells, up to shifts by periods"
      : manifest.neighbors ? "every facet is shared by two cells that name each other, or is on the hull"
                           : "every facet is shared by two cells, or is on the hull",
      "every facet inside is locally Delaunay, exactly, with the perturbation's tie rule",
      is_periodic(manifest) ? "the cells fill the periodic space exactly once: their volumes add up to that of a period"
                            : "the hull is closed, convex and encloses its interior exactly once",
      "the tiles' boxes cover space without overlap, and each vertex is of the tile that the partition gives it to; "
      "the bounds are the vertices'"};
  if (manifest.digest) lines.push_back("the digest " + digest_text(*manifest.digest));
  return lines;
}

}  // namespace

Result<VerifyReport> verify(const fs::path& out, const VerifyOptions& options, std::stop_token stop) {
  BOOST_OUTCOME_TRY(source, TileSource::open(out, Periods::known));
  const Manifest& manifest = source.manifest();
  if (manifest.region)
    return error(Errc::usage, out.string() +
                                  ": holds a region of a triangulation; its cells were compared, when they were made, "
                                  "with points that it does not hold, so that it cannot be proved by itself");
  VerifyReport report;
  BOOST_OUTCOME_TRY(scratch, folder_for_temporary(options.scratch));
  BOOST_OUTCOME_TRYV(check_files(source));
  // A tile is in memory once, with its facets when neighbours must be found. The four sorters share the rest.
  const std::uint64_t tile_bytes = largest_tile(source) * (manifest.neighbors ? 1 : 3);
  const std::uint64_t rest = options.memory_bytes > tile_bytes ? options.memory_bytes - tile_bytes : 0;
  const std::uint64_t share = std::max<std::uint64_t>(rest / 5, std::uint64_t{1} << 20);
  ExternalSort<CellCopy> copies(scratch, share, stop);
  ExternalSort<OwnVertex> own(scratch, share, stop);
  ExternalSort<FacetClaim> claims(scratch, share, stop);
  Hull hull(manifest.dimension, source, scratch, share, stop);
  std::optional<PeriodicSpace> space;
  if (is_periodic(manifest)) space.emplace(manifest.dimension, source.period(), source, scratch, share, stop);
  std::optional<AgainstCgal> cgal;
  if (options.against_cgal) cgal.emplace(manifest.dimension, source.period(), stop);

  Contents contents;
  Owners owners(manifest);
  TileSinks sinks{copies, own, claims, hull, space ? &*space : nullptr};
  for (std::size_t i = 0; i < source.tiles(); ++i) {
    if (stop.stop_requested()) return error(Errc::interrupted, "interrupted while verifying");
    const TileEntry& entry = source.entry(i);
    BOOST_OUTCOME_TRY(mesh, open_tile(source.stopped_by(stop), i));
    const bool neighbors_stored = !mesh.neighbors.empty();
    if (!neighbors_stored) {
      BOOST_OUTCOME_TRYV(match_facets(mesh, source.file(i), stop));
    }
    BOOST_OUTCOME_TRYV(check_tile(mesh, entry.tile, neighbors_stored, source, sinks, stop));
    if (cgal) cgal->add(mesh);
    contents.add(mesh);
    owners.look_at(mesh, entry.tile, source);
    report.cells += entry.main_cells;
    report.vertices += entry.own_points;
  }
  BOOST_OUTCOME_TRY(duplicates, source.read_duplicates());
  BOOST_OUTCOME_TRYV(check_vertex_ids(own, manifest, std::move(duplicates), source));
  BOOST_OUTCOME_TRYV(check_cell_copies(copies, manifest.dimension, source));
  BOOST_OUTCOME_TRYV(check_claims(claims, source));
  BOOST_OUTCOME_TRYV(space ? space->finish() : hull.finish());
  if (report.cells != manifest.cells)
    return error(Errc::not_delaunay, manifest_file(out).string() + ": counts " + std::to_string(manifest.cells) +
                                         " cells, but the tiles have " + std::to_string(report.cells) + " main cells");
  if (report.cells == 0) return error(Errc::not_delaunay, out.string() + ": holds no cell");
  BOOST_OUTCOME_TRYV(check_boxes(manifest, out));
  BOOST_OUTCOME_TRYV(owners.finish());
  BOOST_OUTCOME_TRYV(check_contents(contents, source));
  report.facets = sinks.facets;
  report.hull_facets = space ? space->hull_facets() : hull.facets();

  report.passed = proved(manifest);
  if (cgal) {
    BOOST_OUTCOME_TRYV(cgal->compare(out));
    report.passed.emplace_back("the set of cells equals that of CGAL's triangulation of all vertices");
  }
  return report;
}

}  // namespace tessera

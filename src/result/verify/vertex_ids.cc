#include "src/result/verify/vertex_ids.h"

#include <algorithm>
#include <optional>
#include <string>

#include "src/base/files/names.h"
#include "src/result/verify/cell_ref.h"

namespace tessera {

Status check_vertex_ids(ExternalSort<OwnVertex>& own, const Manifest& manifest, std::vector<DuplicatePair> duplicates,
                        const TileSource& source) {
  const auto wrong = [&](const std::string& reason) {
    return error(Errc::not_delaunay, manifest_file(source.folder()).string() + ": " + reason);
  };
  if (duplicates.size() != manifest.duplicates)
    return wrong("counts " + std::to_string(manifest.duplicates) + " duplicates, but duplicates.bin lists " +
                 std::to_string(duplicates.size()));
  // They ascend. A pair with a number beyond all points could hide that a point was lost.
  if (!duplicates.empty() && duplicates.back().duplicate.value >= manifest.points_read)
    return error(Errc::not_delaunay, duplicates_of(source.folder(), manifest).string() + ": point " +
                                         to_string(duplicates.back().duplicate) + " is not one of the " +
                                         std::to_string(manifest.points_read) + " points that were read");
  std::vector<PointId> kept;
  kept.reserve(duplicates.size());
  for (const auto& pair : duplicates) kept.push_back(pair.kept);
  std::sort(kept.begin(), kept.end());

  std::uint64_t vertices = 0;
  std::optional<OwnVertex> last;
  auto duplicate = duplicates.begin();
  auto wanted = kept.begin();
  BOOST_OUTCOME_TRYV(own.for_each([&](const OwnVertex& vertex) -> Status {
    if (last && last->id == vertex.id)
      return wrong_tile(
          source, vertex.tile,
          "vertex " + to_string(vertex.id) +
              (last->tile == vertex.tile ? " is there twice" : " is also tile " + to_string(last->tile) + "'s own"));
    if (vertex.id.value >= manifest.points_read)
      return wrong_tile(source, vertex.tile,
                        "vertex " + to_string(vertex.id) + " is not one of the " +
                            std::to_string(manifest.points_read) + " points that were read");
    while (duplicate != duplicates.end() && duplicate->duplicate < vertex.id) ++duplicate;
    if (duplicate != duplicates.end() && duplicate->duplicate == vertex.id)
      return wrong_tile(source, vertex.tile,
                        "vertex " + to_string(vertex.id) + " is listed in duplicates.bin as a duplicate");
    if (wanted != kept.end() && *wanted < vertex.id)
      return error(Errc::not_delaunay, duplicates_of(source.folder(), manifest).string() + ": point " +
                                           to_string(*wanted) + " was kept for a duplicate, but is not a vertex");
    while (wanted != kept.end() && *wanted == vertex.id) ++wanted;
    last = vertex;
    ++vertices;
    return success();
  }));
  if (wanted != kept.end())
    return error(Errc::not_delaunay, duplicates_of(source.folder(), manifest).string() + ": point " +
                                         to_string(*wanted) + " was kept for a duplicate, but is not a vertex");
  if (vertices != manifest.vertices)
    return wrong("counts " + std::to_string(manifest.vertices) + " vertices, but the tiles own " +
                 std::to_string(vertices));
  // Subtracted one by one: the manifest may hold any numbers, and a sum could wrap around to the right one.
  std::uint64_t left = manifest.points_read;
  bool fits = true;
  for (const std::uint64_t count : {vertices, manifest.duplicates, manifest.invalid, manifest.filtered}) {
    fits = fits && count <= left;
    left -= fits ? count : 0;
  }
  if (!fits || left != 0)
    return wrong("of " + std::to_string(manifest.points_read) + " points, " + std::to_string(vertices) +
                 " are vertices, " + std::to_string(manifest.duplicates) + " duplicates, " +
                 std::to_string(manifest.invalid) + " invalid and " + std::to_string(manifest.filtered) +
                 " filtered: " + (fits ? "some were lost" : "they are more than there were"));
  return success();
}

}  // namespace tessera

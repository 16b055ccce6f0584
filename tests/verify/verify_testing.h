// Results for verify() to judge: stored as they are given, sound or damaged.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "src/result/verify/verify.h"
#include "tests/store/sample_result.h"

namespace tessera::test {

using Meshes = std::vector<TileMesh>;

inline std::size_t corners(const TileMesh& mesh) { return static_cast<std::size_t>(mesh.dimension) + 1; }
inline std::size_t vertex(const TileMesh& mesh, std::size_t cell, std::size_t k) {
  return static_cast<std::size_t>(mesh.cells[cell * corners(mesh) + k]);
}

inline std::set<PointId> ids_of(const TileMesh& mesh, std::size_t cell) {
  std::set<PointId> ids;
  for (std::size_t k = 0; k < corners(mesh); ++k) ids.insert(mesh.ids[vertex(mesh, cell, k)]);
  return ids;
}

inline Result<VerifyReport> verify_meshes(const Meshes& meshes, bool neighbors = true) {
  const TemporaryFolder folder;
  StoreOptions options;
  options.neighbors = neighbors;
  store_sample(folder.path() / "out", meshes, options);
  return verify(folder.path() / "out", {}, {});
}

// verify() says not_delaunay, in a sentence with these words.
inline void expect_wrong(const Meshes& meshes, const std::string& words, bool neighbors = true) {
  const auto result = verify_meshes(meshes, neighbors);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Errc::not_delaunay) << result.error().where;
  EXPECT_NE(result.error().where.find(words), std::string::npos) << result.error().where;
}

}  // namespace tessera::test

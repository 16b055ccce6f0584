// Reads the PLY files that surfaces are written to, to check them.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/surface/recipe.h"

namespace tessera {
class ByteSource;
}

namespace tessera::surface {

// One file. All of its content is untrusted.
class MeshFile {
 public:
  // Reads the header and the vertices' ids. Errors: of reading the file; bad_input when it is no binary PLY with ids
  // and triangles.
  static Result<MeshFile> open(const std::filesystem::path& path);
  MeshFile(MeshFile&&) noexcept;
  MeshFile& operator=(MeshFile&&) noexcept;
  ~MeshFile();

  const std::filesystem::path& path() const { return path_; }
  const std::optional<Recipe>& recipe() const { return recipe_; }
  std::uint64_t vertices() const { return ids_.size(); }
  std::uint64_t triangles() const { return triangles_; }
  // Visit vertices or triangles in the file's order. Error bad_input when a triangle has a number that is no vertex, or
  // has a vertex twice.
  Status for_each_vertex(const std::function<Status(PointId id, const Point& at)>& visit) const;
  Status for_each_triangle(const std::function<Status(const std::array<PointId, 3>&)>& visit) const;

 private:
  MeshFile() = default;
  Status read_head();
  Status read_ids();
  Error bad(const std::string& why) const { return error(Errc::bad_input, path_.string() + ": " + why); }
  // Visits `count` records of `bytes` bytes, from the offset `at` on; reads them in blocks.
  Status for_each_record(std::uint64_t at, std::uint64_t count, std::size_t bytes,
                         const std::function<Status(const std::byte* record, std::uint64_t number)>& visit) const;

  std::filesystem::path path_;
  std::unique_ptr<ByteSource> source_;
  std::optional<Recipe> recipe_;
  std::vector<PointId> ids_;
  std::uint64_t vertices_ = 0, triangles_ = 0, vertices_at_ = 0, triangles_at_ = 0;
  std::size_t vertex_bytes_ = 0, triangle_bytes_ = 0, x_at_ = 0, id_at_ = 0;
  bool small_ids_ = true;
};

}  // namespace tessera::surface

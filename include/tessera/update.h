// Changes results: removes points and adds others (docs/updates.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <stop_token>

#include "tessera/failure.h"
#include "tessera/triangulation.h"
#include "tessera/visibility.h"

namespace tessera {

// What is to be changed. Every function returns *this.
class TESSERA_PUBLIC UpdateRequest {
 public:
  UpdateRequest();
  UpdateRequest(const UpdateRequest&);
  UpdateRequest& operator=(const UpdateRequest&);
  ~UpdateRequest();

  // New points. Shape: n x dimension of the result, row after row; or rows of named columns, with the attributes of the
  // result as columns of the same types. Their source indices go on where those of the result end. The memory must not
  // change until update() has returned.
  UpdateRequest& add(std::span<const double> coordinates);
  UpdateRequest& add(const Records& records);
  // The source indices of points to remove. They are copied.
  UpdateRequest& remove(std::span<const std::uint64_t> ids);
  // New points take the places of all points with the same coordinates, which are removed. Otherwise a new point with
  // the coordinates of another becomes a duplicate, or the vertex, as the result's choice among equal points says.
  UpdateRequest& replace(bool replace);
  // The folder of the new result, which must not exist. Without one the result itself gets a new version.
  UpdateRequest& output(const std::filesystem::path& folder);
  // 0, the default: all processors.
  UpdateRequest& threads(unsigned threads);
  UpdateRequest& stop(std::stop_token stop);

 private:
  friend struct OptionsInside;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// What a change has done. Programs are compiled with the size of this struct, so it never changes.
struct UpdateReport {
  std::uint64_t first_id = 0;     // the source index of the first new point
  std::uint64_t removed = 0;      // points, those included that others have replaced
  std::uint64_t added = 0;        // points
  std::uint64_t equal = 0;        // new points with the coordinates of others
  std::uint64_t tiles = 0;        // of the changed result
  std::uint64_t tiles_awake = 0;  // tiles that were triangulated again
  std::uint64_t tiles_changed = 0;
};

// Changes a result; open the folder of the new one to read it. The outcome is the triangulation from scratch of the
// points that are left, with the same source indices. Failure: usage when the result cannot be changed, when a point to
// be removed does not exist, when new points have other attributes, when the points that are left do not span space,
// and when the folder exists; bad_input for a coordinate that is not finite; corrupt, io, memory, interrupted.
TESSERA_PUBLIC UpdateReport update(const Triangulation& triangulation, const UpdateRequest& request);

}  // namespace tessera

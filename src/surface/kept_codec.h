// Encodes what the steps of a surface keep of a tile (src/surface/step.h). Each reader returns false when the bytes are
// not what its writer made.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "src/surface/cut/cut_graph.h"
#include "src/surface/region.h"
#include "src/surface/step_store.h"
#include "src/surface/surface_tile.h"
#include "src/surface/umbrellas.h"

namespace tessera::surface {

struct RayCounts {
  std::uint64_t rays = 0, no_rays = 0, guessed = 0, steps = 0, handed_over = 0;
  RayCounts& operator+=(const RayCounts& other) {
    rays += other.rays;
    no_rays += other.no_rays;
    guessed += other.guessed;
    steps += other.steps;
    handed_over += other.handed_over;
    return *this;
  }
};

Bytes bytes_of(const RayCounts& counts);
bool read(std::span<const std::byte> bytes, RayCounts& counts);

struct KeptRays {
  RayCounts counts;
  SurfaceTile::Weights weights;
};
Bytes bytes_of(const KeptRays& rays);
bool read(std::span<const std::byte> bytes, KeptRays& rays);

// What a tile has decided alone.
struct KeptSides {
  std::uint64_t undecided = 0;
  cut::CellSet sources, open;  // of its main cells
};
Bytes bytes_of(const KeptSides& sides);
bool read(std::span<const std::byte> bytes, KeptSides& sides);

// What a tile has not decided: a region's kernel, without `sources` and `open`.
Bytes bytes_of(const ReducedRegion& kernel);
bool read(std::span<const std::byte> bytes, ReducedRegion& kernel);

// What a group has decided (groups.h); kept at its first tile.
struct KeptGroup {
  std::uint64_t cells = 0;           // cells that its members have left undecided
  std::vector<std::uint32_t> first;  // by member: its first cell
  cut::CellSet sources, open;        // of these cells
};
Bytes bytes_of(const KeptGroup& group);
bool read(std::span<const std::byte> bytes, KeptGroup& group);

// The median scale that the first tile has found in the step scales, or the scale that was given.
bool read(std::span<const std::byte> bytes, double& sigma);

struct KeptTriangles {
  std::uint64_t outside = 0;  // main cells that are outside
  Bytes entry;                // what StepStore::keep_triangles() returned
  Splits splits;
};
Bytes bytes_of(const KeptTriangles& triangles);
bool read(std::span<const std::byte> bytes, KeptTriangles& triangles);

}  // namespace tessera::surface

#include "src/surface/kept_codec.h"

#include <utility>

#include "src/base/flat_codec.h"

namespace tessera::surface {

namespace {

void put(FlatWriter& out, const cut::CellSet& set) { out.list(set.words()); }

bool get(FlatReader& in, cut::CellSet& set) {
  std::vector<std::uint64_t> words;
  if (!in.list(words)) return false;
  set = cut::CellSet::of_words(std::move(words));
  return true;
}

}  // namespace

Bytes bytes_of(const RayCounts& counts) {
  FlatWriter out;
  out.value(counts);
  return out.take();
}

bool read(std::span<const std::byte> bytes, RayCounts& counts) {
  FlatReader in(bytes);
  return in.value(counts) && in.at_end();
}

Bytes bytes_of(const KeptRays& rays) {
  FlatWriter out;
  out.reserve(rays.weights.arcs.size() * 4 + rays.weights.excess.size() * 8 + 64);
  out.value(rays.counts);
  out.list(rays.weights.arcs);
  out.list(rays.weights.excess);
  return out.take();
}

bool read(std::span<const std::byte> bytes, KeptRays& rays) {
  FlatReader in(bytes);
  return in.value(rays.counts) && in.list(rays.weights.arcs) && in.list(rays.weights.excess) && in.at_end();
}

Bytes bytes_of(const KeptSides& sides) {
  FlatWriter out;
  out.value(sides.undecided);
  put(out, sides.sources);
  put(out, sides.open);
  return out.take();
}

bool read(std::span<const std::byte> bytes, KeptSides& sides) {
  FlatReader in(bytes);
  return in.value(sides.undecided) && get(in, sides.sources) && get(in, sides.open) && in.at_end();
}

Bytes bytes_of(const ReducedRegion& region) {
  FlatWriter out;
  const cut::CutGraph& graph = region.kernel.graph;
  out.list(graph.excess);
  out.list(graph.capacity);
  out.list(graph.back);
  out.list(graph.borders);
  out.list(region.kernel.borders);
  out.list(region.names);
  out.list(region.at_border);
  return out.take();
}

bool read(std::span<const std::byte> bytes, ReducedRegion& region) {
  FlatReader in(bytes);
  cut::CutGraph& graph = region.kernel.graph;
  return in.list(graph.excess) && in.list(graph.capacity) && in.list(graph.back) && in.list(graph.borders) &&
         in.list(region.kernel.borders) && in.list(region.names) && in.list(region.at_border) && in.at_end();
}

Bytes bytes_of(const KeptGroup& group) {
  FlatWriter out;
  out.value(group.cells);
  out.list(group.first);
  put(out, group.sources);
  put(out, group.open);
  return out.take();
}

bool read(std::span<const std::byte> bytes, KeptGroup& group) {
  FlatReader in(bytes);
  return in.value(group.cells) && in.list(group.first) && get(in, group.sources) && get(in, group.open) && in.at_end();
}

bool read(std::span<const std::byte> bytes, double& sigma) {
  FlatReader in(bytes);
  return in.value(sigma) && in.at_end();
}

Bytes bytes_of(const KeptTriangles& triangles) {
  FlatWriter out;
  out.value(triangles.outside);
  out.list(triangles.entry);
  out.list(triangles.splits.corners);
  out.list(triangles.splits.places);
  out.list(triangles.splits.pairs);
  return out.take();
}

bool read(std::span<const std::byte> bytes, KeptTriangles& triangles) {
  FlatReader in(bytes);
  return in.value(triangles.outside) && in.list(triangles.entry) && in.list(triangles.splits.corners) &&
         in.list(triangles.splits.places) && in.list(triangles.splits.pairs) && in.at_end();
}

}  // namespace tessera::surface

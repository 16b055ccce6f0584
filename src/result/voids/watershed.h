// The watershed of a result, tile by tile. The zones follow from the columns of densities alone, whatever the tiles.
//
//   flow    | each tile finds where its own vertices flow to (tile_flow.h), the only step that needs cells, and asks the
//           | owners of its foreign vertices where those flow to
//   answers | each tile answers. A foreign vertex at which a chain leaves a tile is an exit; the answers of all exits,
//           | which are in memory, lead each exit to a core
//   zones   | each tile translates its roots to zones, gives the saddles to the graph, and its vertices' zones to the
//           | caller
//
// So three rounds over the tiles are enough, however long the chains are. A message between tiles is a file in the
// scratch folder, because each round begins after all tiles have ended the one before. Memory holds the tiles that are
// being worked on, the exits, and the graph of zones.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/result/tile_source.h"
#include "src/result/voids/densities.h"
#include "src/result/voids/tile_flow.h"
#include "src/result/voids/zone_graph.h"

namespace tessera::voids {

struct WatershedOptions {
  unsigned threads = 1;
  std::uint64_t memory_bytes = 0;  // budget of the tiles; a single tile may exceed it
  std::stop_token stop = {};
  std::function<void(double)> progress = {};  // gets the fraction done, 0..1, from one thread at a time; may be null
};

class Watershed {
 public:
  // `scratch` is an empty folder.
  Watershed(const TileSource& source, Densities densities, std::filesystem::path scratch, WatershedOptions options)
      : source_(source.stopped_by(options.stop)),
        densities_(std::move(densities)),
        scratch_(std::move(scratch)),
        options_(std::move(options)) {}

  // About the most bytes that run() writes into the scratch folder.
  std::uint64_t scratch_bytes() const;
  // Receives the zones of a tile's vertices, foreign ones included, in the order of the file. Called by several
  // threads, once for each tile. `flow` has the numbers and source indices of the vertices.
  using Taker = std::function<Status(std::size_t index, const TileFlow& flow, std::span<const ZoneNumber> zones)>;
  // Errors: those of reading, of Densities::of() and of `take`; corrupt when tiles contradict each other; memory for
  // 2^32 zones; io; interrupted.
  Status run(const Taker& take);

  // After run().
  ZoneGraph& graph() { return graph_; }
  const ZoneGraph& graph() const { return graph_; }
  // The highest density of a vertex that is in a zone; nothing when none is.
  std::optional<Level> highest() const { return highest_; }
  // How many vertices, and how many points, are in no zone.
  std::uint64_t vertices_outside() const { return vertices_outside_; }

 private:
  // A tile asks for a foreign vertex; its level tells whether both tiles have the same columns.
  struct Question {
    PointId vertex;
    double level = 0;
    std::uint32_t from = 0;  // the asking tile's number
    std::uint32_t exit = 0;  // 1: a chain of the asking tile ends there
  };
  struct Answer {
    PointId vertex, root;
  };
  static constexpr PointId no_root{std::numeric_limits<std::uint64_t>::max()};

  Status on_tiles(double from, double to, double tile_factor, const std::function<Status(std::size_t)>& work);
  Status flow(std::size_t index);
  Status ask(std::size_t index, const TileFlow& flow);
  void note_cores(const TileMesh& mesh, const TileFlow& flow);
  Status answer(std::size_t index);
  Result<Answer> answer_to(std::size_t index, const Question& question, const TileFlow& flow,
                           std::span<const std::pair<PointId, Node>> own);
  Status resolve_exits();
  Status translate(std::size_t index, const Taker& take);
  Result<std::vector<ZoneNumber>> zones_of_nodes(std::size_t index, const TileFlow& flow) const;
  ZoneNumber zone_of(PointId root) const;
  Error contradiction(std::size_t index, PointId vertex, const char* what) const;
  Status append(const std::filesystem::path& path, std::size_t to, std::span<const std::byte> records);

  TileSource source_;
  Densities densities_;
  std::filesystem::path scratch_;
  WatershedOptions options_;
  std::array<std::mutex, 64> appending_;  // locks, chosen by the receiving tile
  std::mutex mutex_;                      // of what follows
  std::vector<Zone> cores_;               // until graph_ has them
  std::vector<Answer> exits_;             // by vertex, each once
  std::vector<ZoneNumber> exit_zones_;    // by exit
  ZoneGraph graph_;
  std::optional<Level> highest_;
  std::uint64_t vertices_outside_ = 0;
};

}  // namespace tessera::voids

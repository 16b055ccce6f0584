#include "src/result/voids/watershed.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "src/base/files/disk_file.h"
#include "src/base/files/there.h"
#include "src/base/files/voids_names.h"
#include "src/result/tile_queue.h"

namespace tessera::voids {

namespace fs = std::filesystem;

namespace {

// The parts of the progress.
constexpr double flow_end = 0.6, answers_end = 0.7;

// All records of a file; none when there is no file.
template <class Record>
Result<std::vector<Record>> read_records(const fs::path& path) {
  std::vector<Record> records;
  BOOST_OUTCOME_TRY(there, is_there(path));
  if (!there) return records;
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::read));
  BOOST_OUTCOME_TRY(bytes, file.size());
  records.resize(bytes / sizeof(Record));
  BOOST_OUTCOME_TRY(read, file.read(std::as_writable_bytes(std::span(records))));
  if (read != records.size() * sizeof(Record)) return error(Errc::io, path.string() + ": is shorter than it was");
  return records;
}

}  // namespace

std::uint64_t Watershed::scratch_bytes() const {
  // Of a vertex: its number, id, level, owner or root; a foreign one, besides: a question, an answer, and saddles with
  // its neighbours, a few each. Basins and saddles between own vertices are fewer than these.
  constexpr std::uint64_t of_a_vertex = 4 + 1 + 8 + 8 + 4 + 24;
  constexpr std::uint64_t of_a_foreign = sizeof(Question) + sizeof(Answer) + 6 * sizeof(TileSaddle);
  std::uint64_t bytes = 0;
  for (const TileEntry& entry : source_.manifest().tiles)
    bytes += entry.points * of_a_vertex + (entry.points - std::min(entry.points, entry.own_points)) * of_a_foreign;
  return bytes;
}

Status Watershed::run(const Taker& take) {
  BOOST_OUTCOME_TRYV(on_tiles(0, flow_end, 2.5, [&](std::size_t index) { return flow(index); }));
  if (cores_.size() >= no_zone)
    return error(Errc::memory, source_.folder().string() + ": has more zones than can be numbered, 2^32");
  graph_ = ZoneGraph(std::exchange(cores_, {}));
  BOOST_OUTCOME_TRYV(on_tiles(flow_end, answers_end, 1, [&](std::size_t index) { return answer(index); }));
  BOOST_OUTCOME_TRYV(resolve_exits());
  return on_tiles(answers_end, 1, 1, [&](std::size_t index) { return translate(index, take); });
}

Status Watershed::on_tiles(double from, double to, double tile_factor, const std::function<Status(std::size_t)>& work) {
  const auto told = [&](double done) {
    if (options_.progress) options_.progress(from + (to - from) * done);
  };
  return for_each_tile(source_,
                       {.threads = options_.threads,
                        .memory_bytes = options_.memory_bytes,
                        .tile_factor = tile_factor,
                        .stop = options_.stop,
                        .progress = told},
                       [&](const TileSource&, std::size_t index) { return work(index); });
}

Error Watershed::contradiction(std::size_t index, PointId vertex, const char* what) const {
  return error(Errc::corrupt, source_.file(index).string() + ": foreign vertex " + to_string(vertex) + " " + what);
}

Status Watershed::append(const fs::path& path, std::size_t to, std::span<const std::byte> records) {
  const std::lock_guard lock(appending_[to % appending_.size()]);
  BOOST_OUTCOME_TRY(file, DiskFile::open(path, DiskFile::Mode::append));
  BOOST_OUTCOME_TRYV(file.write(records));
  return file.close();
}

Status Watershed::flow(std::size_t index) {
  BOOST_OUTCOME_TRY(tile, source_.read(index, {.cells = true, .rows = true, .cell_columns = false}));
  BOOST_OUTCOME_TRY(densities, densities_.of(source_, index, tile));
  tile.rows = {};
  BOOST_OUTCOME_TRY(flow, TileFlow::of(source_, index, tile.mesh, densities, options_.stop));
  BOOST_OUTCOME_TRYV(flow.write(voids_flow_file(scratch_, source_.entry(index).tile)));
  note_cores(tile.mesh, flow);
  return ask(index, flow);
}

void Watershed::note_cores(const TileMesh& mesh, const TileFlow& flow) {
  std::vector<Zone> cores;
  std::optional<Level> highest;
  std::uint64_t outside = 0;
  for (std::size_t v = 0; v < mesh.ids.size(); ++v) {
    if (mesh.point_ghost[v] != 0) continue;
    const Node node = flow.nodes[v];
    if (flow.roots[node] == no_node) {
      ++outside;
      continue;
    }
    const Level level{flow.levels[node], flow.ids[node]};
    if (!highest || *highest < level) highest = level;
    if (flow.is_core(node)) cores.push_back({.core = level, .place = mesh.points[v], .points = 0, .volume = {}});
  }
  const std::lock_guard lock(mutex_);
  cores_.insert(cores_.end(), cores.begin(), cores.end());
  if (highest && (!highest_ || *highest_ < *highest)) highest_ = highest;
  vertices_outside_ += outside;
}

// Foreign nodes are asked for by owner.
Status Watershed::ask(std::size_t index, const TileFlow& flow) {
  std::vector<std::uint32_t> exits(flow.ids.size() - flow.own, 0);
  for (const Node root : flow.roots)
    if (root != no_node && root >= flow.own) exits[root - flow.own] = 1;
  std::vector<Node> foreign(exits.size());
  std::iota(foreign.begin(), foreign.end(), static_cast<Node>(flow.own));
  const auto owner = [&](Node node) { return flow.owners[node - flow.own]; };
  std::stable_sort(foreign.begin(), foreign.end(), [&](Node a, Node b) { return owner(a) < owner(b); });
  std::vector<Question> questions;
  for (std::size_t i = 0; i < foreign.size(); ++i) {
    const Node node = foreign[i];
    questions.push_back({.vertex = flow.ids[node],
                         .level = flow.levels[node],
                         .from = static_cast<std::uint32_t>(index),
                         .exit = exits[node - flow.own]});
    if (i + 1 < foreign.size() && owner(foreign[i + 1]) == owner(node)) continue;
    const auto to = source_.find(owner(node));
    if (!to) return contradiction(index, flow.ids[node], "is of a tile that the manifest does not have");
    BOOST_OUTCOME_TRYV(append(voids_asked_file(scratch_, owner(node)), *to, std::as_bytes(std::span(questions))));
    questions.clear();
  }
  return success();
}

Status Watershed::answer(std::size_t index) {
  const TileId tile = source_.entry(index).tile;
  BOOST_OUTCOME_TRY(questions, read_records<Question>(voids_asked_file(scratch_, tile)));
  if (questions.empty()) return success();
  BOOST_OUTCOME_TRY(flow, TileFlow::read(voids_flow_file(scratch_, tile)));
  std::vector<std::pair<PointId, Node>> own;
  for (Node node = 0; node < flow.own; ++node) own.emplace_back(flow.ids[node], node);
  std::sort(own.begin(), own.end());
  // A tile that asks stands in the file as often as its batches came.
  std::stable_sort(questions.begin(), questions.end(), [](const auto& a, const auto& b) { return a.from < b.from; });
  std::vector<Answer> answers, exits;
  for (std::size_t i = 0; i < questions.size(); ++i) {
    const Question& question = questions[i];
    BOOST_OUTCOME_TRY(answer, answer_to(index, question, flow, own));
    answers.push_back(answer);
    if (question.exit != 0) exits.push_back(answer);
    if (i + 1 < questions.size() && questions[i + 1].from == question.from) continue;
    BOOST_OUTCOME_TRYV(append(voids_answers_file(scratch_, source_.entry(question.from).tile), question.from,
                              std::as_bytes(std::span(answers))));
    answers.clear();
  }
  const std::lock_guard lock(mutex_);
  exits_.insert(exits_.end(), exits.begin(), exits.end());
  return success();
}

Result<Watershed::Answer> Watershed::answer_to(std::size_t index, const Question& question, const TileFlow& flow,
                                               std::span<const std::pair<PointId, Node>> own) {
  const auto found = std::lower_bound(own.begin(), own.end(), std::pair(question.vertex, Node{0}));
  if (found == own.end() || found->first != question.vertex)
    return contradiction(question.from, question.vertex, "is missing in the tile that owns it");
  const Node node = found->second;
  if (!same_level(flow.levels[node], question.level))
    return contradiction(question.from, question.vertex,
                         ("has another density than in " + source_.file(index).string() +
                          ", the tile that owns it; compute the columns again")
                             .c_str());
  const Node root = flow.roots[node];
  return Answer{question.vertex, root == no_node ? no_root : flow.ids[root]};
}

// Chains go down from exit to exit, so they end at a core.
Status Watershed::resolve_exits() {
  std::sort(exits_.begin(), exits_.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
  const auto same = [](const Answer& a, const Answer& b) { return a.vertex == b.vertex; };
  exits_.erase(std::unique(exits_.begin(), exits_.end(), same), exits_.end());
  exits_.shrink_to_fit();
  exit_zones_.assign(exits_.size(), no_zone);
  std::vector<std::size_t> chain;
  for (std::size_t i = 0; i < exits_.size(); ++i) {
    ZoneNumber zone = no_zone;
    for (std::size_t at = i;;) {
      if (exit_zones_[at] != no_zone) {
        zone = exit_zones_[at];
        break;
      }
      chain.push_back(at);
      const PointId root = exits_[at].root;
      zone = graph_.find(root);
      if (zone != no_zone) break;
      const auto next = std::lower_bound(exits_.begin(), exits_.end(), root,
                                         [](const Answer& exit, PointId id) { return exit.vertex < id; });
      if (next == exits_.end() || next->vertex != root || chain.size() > exits_.size())
        return error(Errc::corrupt, source_.folder().string() + ": vertex " + to_string(exits_[i].vertex) +
                                        " flows to no core, so the tiles contradict each other");
      at = static_cast<std::size_t>(next - exits_.begin());
    }
    for (const std::size_t passed : chain) exit_zones_[passed] = zone;
    chain.clear();
  }
  return success();
}

ZoneNumber Watershed::zone_of(PointId root) const {
  const ZoneNumber zone = graph_.find(root);
  if (zone != no_zone) return zone;
  const auto exit = std::lower_bound(exits_.begin(), exits_.end(), root,
                                     [](const Answer& one, PointId id) { return one.vertex < id; });
  if (exit == exits_.end() || exit->vertex != root) return no_zone;
  return exit_zones_[static_cast<std::size_t>(exit - exits_.begin())];
}

// Of own nodes by their roots, of foreign ones by the answers.
Result<std::vector<ZoneNumber>> Watershed::zones_of_nodes(std::size_t index, const TileFlow& flow) const {
  BOOST_OUTCOME_TRY(answers, read_records<Answer>(voids_answers_file(scratch_, source_.entry(index).tile)));
  std::sort(answers.begin(), answers.end(), [](const auto& a, const auto& b) { return a.vertex < b.vertex; });
  std::vector<ZoneNumber> zones(flow.ids.size(), no_zone);
  for (std::size_t node = flow.own; node < zones.size(); ++node) {
    const std::size_t i = node - flow.own;
    if (i >= answers.size() || answers[i].vertex != flow.ids[node])
      return contradiction(index, flow.ids[node], "is missing in the tile that owns it");
    if (answers[i].root != no_root) zones[node] = zone_of(answers[i].root);
  }
  for (const Basin& basin : flow.basins)
    if (basin.root < flow.own) zones[basin.root] = zone_of(flow.ids[basin.root]);
  for (std::size_t node = 0; node < flow.own; ++node)
    if (flow.roots[node] != no_node) zones[node] = zones[flow.roots[node]];
  for (std::size_t node = 0; node < zones.size(); ++node)
    if ((zones[node] == no_zone) != std::isnan(flow.levels[node]))
      return error(Errc::corrupt, source_.file(index).string() + ": vertex " + to_string(flow.ids[node]) +
                                      " flows to no core, so the tiles contradict each other");
  return zones;
}

Status Watershed::translate(std::size_t index, const Taker& take) {
  BOOST_OUTCOME_TRY(flow, TileFlow::read(voids_flow_file(scratch_, source_.entry(index).tile)));
  BOOST_OUTCOME_TRY(of_nodes, zones_of_nodes(index, flow));
  std::vector<Saddle> saddles;
  for (const TileSaddle& one : flow.saddles) {
    const ZoneNumber a = of_nodes[one.a], b = of_nodes[one.b];
    if (a != b) saddles.push_back({std::min(a, b), std::max(a, b), one.level});
  }
  {
    const std::lock_guard lock(mutex_);
    graph_.add(saddles);
    for (const Basin& basin : flow.basins) {
      Zone& zone = graph_.zones()[of_nodes[basin.root]];
      zone.points += basin.points;
      zone.volume.add(basin.volume);
    }
  }
  saddles = {};
  std::vector<ZoneNumber> zones(flow.nodes.size());
  for (std::size_t v = 0; v < zones.size(); ++v) zones[v] = of_nodes[flow.nodes[v]];
  return take(index, flow, zones);
}

}  // namespace tessera::voids

#include "src/job/report/progress_line.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "src/base/json/json_text.h"
#include "src/base/phases.h"
#include "src/job/report/human.h"

namespace tessera {
namespace {

double ratio(double part, double whole) { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; }

// Return a counter of a snapshot, or of a node, which has only the counters of tiles.
std::uint64_t count_of(const NodeProgress& of, ProgressCounter counter) {
  if (counter == ProgressCounter::tiles_triangulated) return of.tiles_triangulated;
  return counter == ProgressCounter::tiles_stored ? of.tiles_stored : 0;
}

std::uint64_t count_of(const ProgressSnapshot& of, ProgressCounter counter) {
  switch (counter) {
    case ProgressCounter::points_routed:
      return of.points_routed;
    case ProgressCounter::points_triangulated:
      return of.points_triangulated;
    case ProgressCounter::points_sent:
      return of.points_sent;
    case ProgressCounter::tiles_triangulated:
      return of.tiles_triangulated;
    case ProgressCounter::tiles_stored:
      return of.tiles_stored;
    case ProgressCounter::none:
      break;
  }
  return 0;
}

double part_of_total(const ProgressSnapshot& now, ProgressCounter counter) {
  const bool of_tiles = counter == ProgressCounter::tiles_triangulated || counter == ProgressCounter::tiles_stored;
  const auto total = of_tiles ? now.tiles_total : now.points_total;
  return ratio(static_cast<double>(count_of(now, counter)), static_cast<double>(total));
}

constexpr int words_width() {
  std::size_t width = 0;
  for (const PhaseRow& row : phase_table) width = std::max(width, std::string_view(row.label).size());
  return static_cast<int>(width);
}

// An update may be counted as processed before updates_sent was read, so the difference is kept from being negative.
std::uint64_t in_flight(const ProgressSnapshot& now) {
  return now.updates_sent - std::min(now.updates_sent, now.updates_processed);
}

// Negative while too little is done for an estimate.
double seconds_left(const ProgressSnapshot& now) {
  const double done = fraction_done(now);
  if (done < 0.03 || now.elapsed_s < 1) return -1;
  return now.elapsed_s * (1 - done) / done;
}

std::string figures(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "   ") + part; };
  const PhaseRow& phase = row_of(now.phase);
  if (now.tiles_total > 0) {
    const auto done = count_of(now, phase.tiles);
    add("tiles " + std::to_string(done) + "/" + std::to_string(now.tiles_total) +
        (now.tiles_asleep > 0 ? " (" + std::to_string(now.tiles_asleep) + " asleep)" : ""));
  } else if (const auto points = count_of(now, phase.points); phase.program == ProgramKind::none && points > 0) {
    add(human_count(points) + " points");
  }
  if (const double rate = points_per_second(before, now); rate > 0) {
    add(human_count(static_cast<std::uint64_t>(rate)) + " points/s");
  }
  if (now.updates_sent > 0) add("in flight " + human_count(in_flight(now)));
  if (now.memory_bytes > 0) add("memory " + human_bytes(now.memory_bytes));
  if (const double left = seconds_left(now); left >= 0) add("ETA " + human_seconds(left));
  return text;
}

// Returns "nodes a 3/12, b 4/13, c lost": of each node how many of its tiles have finished the phase.
std::string nodes_text(const ProgressSnapshot& now) {
  std::string text;
  for (const NodeProgress& node : now.nodes) {
    const auto done = count_of(node, row_of(now.phase).tiles);
    text += (text.empty() ? "nodes " : ", ") + node.name +
            (node.lost ? " lost" : " " + std::to_string(done) + "/" + std::to_string(node.tiles));
  }
  return text;
}

std::string cut(std::string line, int columns) {
  if (columns > 0 && line.size() > static_cast<std::size_t>(columns)) line.resize(static_cast<std::size_t>(columns));
  return line;
}

}  // namespace

ProgressSnapshot look(const Progress& progress, double elapsed_s) {
  ProgressSnapshot now;
  now.elapsed_s = elapsed_s;
  now.phase = progress.phase;
  now.points_total = progress.points_total;
  now.points_routed = progress.points_routed;
  now.points_triangulated = progress.points_triangulated;
  now.tiles_total = progress.tiles_total;
  now.tiles_triangulated = progress.tiles_triangulated;
  now.tiles_stored = progress.tiles_stored;
  now.tiles_asleep = progress.tiles_asleep;
  now.updates_processed = progress.updates_processed;
  now.updates_sent = progress.updates_sent;
  now.points_sent = progress.points_sent;
  now.memory_bytes = progress.memory_bytes;
  now.bytes_between = progress.bytes_between;
  now.credit_waits = progress.credit_waits;
  now.nodes = progress.nodes();
  return now;
}

double fraction_done(const ProgressSnapshot& now) {
  if (row_of(now.phase).over) return 1;
  double all = 0;
  for (const PhaseRow& row : phase_table) {
    double done = row.phase < now.phase ? 1 : 0;
    for (const ProgressCounter counter : row.counters) done = std::max(done, part_of_total(now, counter));
    all += row.share * done;
  }
  return all;
}

double points_per_second(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  const double seconds = now.elapsed_s - before.elapsed_s;
  const auto points = [&](const ProgressSnapshot& at) { return count_of(at, row_of(now.phase).points); };
  if (seconds <= 0 || points(now) <= points(before)) return 0;
  return static_cast<double>(points(now) - points(before)) / seconds;
}

std::vector<std::string> progress_panel(const ProgressSnapshot& before, const ProgressSnapshot& now, int columns) {
  constexpr int name_width = words_width();
  std::string name = row_of(now.phase).label;
  name.resize(name_width, ' ');
  const double done = fraction_done(now);
  const auto percent = std::to_string(static_cast<int>(done * 100));
  const std::string tail =
      std::string(4 - std::min<std::size_t>(3, percent.size()), ' ') + percent + " %  " + human_seconds(now.elapsed_s);
  const int width = std::clamp(columns - name_width - static_cast<int>(tail.size()) - 4, 4, 50);
  const int filled = static_cast<int>(done * width);
  std::vector<std::string> lines{
      cut(name + " [" + std::string(filled, '#') + std::string(width - filled, '.') + "]" + tail, columns),
      cut("  " + figures(before, now), columns)};
  if (!now.nodes.empty()) lines.push_back(cut("  " + nodes_text(now), columns));
  return lines;
}

std::string progress_text(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  const auto details = figures(before, now);
  return human_seconds(now.elapsed_s) + "   " + row_of(now.phase).label + "   " +
         std::to_string(static_cast<int>(fraction_done(now) * 100)) + " %" + (details.empty() ? "" : "   " + details) +
         (now.nodes.empty() ? "" : "   " + nodes_text(now));
}

std::string progress_json(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  nlohmann::ordered_json json{{"event", "progress"},
                              {"phase", name_of(now.phase)},
                              {"elapsed_s", now.elapsed_s},
                              {"fraction", fraction_done(now)},
                              {"points_total", now.points_total},
                              {"points_routed", now.points_routed},
                              {"points_triangulated", now.points_triangulated},
                              {"points_per_s", points_per_second(before, now)},
                              {"tiles_total", now.tiles_total},
                              {"tiles_triangulated", now.tiles_triangulated},
                              {"tiles_stored", now.tiles_stored},
                              {"tiles_asleep", now.tiles_asleep},
                              {"messages_sent", now.updates_sent},
                              {"messages_in_flight", in_flight(now)},
                              {"points_sent", now.points_sent},
                              {"memory_bytes", now.memory_bytes}};
  if (!now.nodes.empty()) {
    auto nodes = nlohmann::ordered_json::array();
    for (const NodeProgress& node : now.nodes) {
      nodes.push_back({{"name", node.name},
                       {"tiles", node.tiles},
                       {"tiles_triangulated", node.tiles_triangulated},
                       {"tiles_stored", node.tiles_stored},
                       {"memory_bytes", node.memory_bytes},
                       {"lost", node.lost}});
    }
    json["nodes"] = std::move(nodes);
    json["bytes_between_nodes"] = now.bytes_between;
    json["credit_waits"] = now.credit_waits;
  }
  const double left = seconds_left(now);
  json["eta_s"] = left < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(left);
  return json_text(json);
}

}  // namespace tessera

#include "src/report/progress_line.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/report/human.h"

namespace tessera {
namespace {

double ratio(double part, double whole) { return whole > 0 ? std::clamp(part / whole, 0.0, 1.0) : 0.0; }

// An update may be counted as processed before the look at updates_sent: never below zero.
std::uint64_t in_flight(const ProgressSnapshot& now) {
  return now.updates_sent - std::min(now.updates_sent, now.updates_processed);
}

// Negative while too little is done to tell.
double seconds_left(const ProgressSnapshot& now) {
  const double done = fraction_done(now);
  if (done < 0.03 || now.elapsed_s < 1) return -1;
  return now.elapsed_s * (1 - done) / done;
}

std::string figures(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : "   ") + part; };
  if (now.tiles_total > 0) {
    const auto done = now.phase >= Phase::collecting ? now.tiles_stored : now.tiles_triangulated;
    add("tiles " + std::to_string(done) + "/" + std::to_string(now.tiles_total) +
        (now.tiles_asleep > 0 ? " (" + std::to_string(now.tiles_asleep) + " asleep)" : ""));
  } else if (now.phase <= Phase::routing && now.points_routed > 0) {
    add(human_count(now.points_routed) + " points");
  }
  if (const double rate = points_per_second(before, now); rate > 0) {
    add(human_count(static_cast<std::uint64_t>(rate)) + " points/s");
  }
  if (now.updates_sent > 0) add("in flight " + human_count(in_flight(now)));
  if (now.memory_bytes > 0) add("memory " + human_bytes(now.memory_bytes));
  if (const double left = seconds_left(now); left >= 0) add("ETA " + human_seconds(left));
  return text;
}

// "nodes a 3/12, b 4/13, c lost": of each how many of its tiles are as far as the phase goes.
std::string nodes_text(const ProgressSnapshot& now) {
  std::string text;
  for (const NodeProgress& node : now.nodes) {
    const auto done = now.phase >= Phase::collecting ? node.tiles_stored : node.tiles_triangulated;
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
  // Shares of the time of 10 M uniform points on two threads, rounded: they only steer the estimate.
  constexpr double routing = 0.08, triangulating = 0.55, splaying = 0.12, collecting = 0.25;
  if (now.phase == Phase::done) return 1;
  const double total = static_cast<double>(now.points_total);
  const double routed = now.phase > Phase::routing ? 1 : ratio(static_cast<double>(now.points_routed), total);
  const double triangulated = now.phase > Phase::triangulating
                                  ? 1
                                  : std::max(ratio(static_cast<double>(now.points_triangulated), total),
                                             ratio(now.tiles_triangulated, now.tiles_total));
  const double splayed = now.phase > Phase::splaying ? 1 : 0;
  const double stored = now.phase > Phase::collecting ? 1 : ratio(now.tiles_stored, now.tiles_total);
  return routing * routed + triangulating * triangulated + splaying * splayed + collecting * stored;
}

double points_per_second(const ProgressSnapshot& before, const ProgressSnapshot& now) {
  const double seconds = now.elapsed_s - before.elapsed_s;
  const auto points = [&](const ProgressSnapshot& at) {
    switch (now.phase) {
      case Phase::planning:
      case Phase::routing:
        return at.points_routed;
      case Phase::triangulating:
        return at.points_triangulated;
      case Phase::splaying:
        return at.points_sent;
      default:
        return std::uint64_t{0};
    }
  };
  if (seconds <= 0 || points(now) <= points(before)) return 0;
  return static_cast<double>(points(now) - points(before)) / seconds;
}

std::vector<std::string> progress_panel(const ProgressSnapshot& before, const ProgressSnapshot& now, int columns) {
  constexpr int name_width = 13;  // "triangulating"
  std::string name = plain_phase(name_of(now.phase));
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
  return human_seconds(now.elapsed_s) + "   " + plain_phase(name_of(now.phase)) + "   " +
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
  return json.dump();
}

}  // namespace tessera

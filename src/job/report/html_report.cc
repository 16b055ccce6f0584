#include "src/job/report/html_report.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "src/base/files/whole_file.h"
#include "src/job/report/human.h"
#include "src/job/report/report_style.h"

namespace tessera {
namespace {

constexpr std::size_t table_rows_max = 1000;

// A number must not be broken at the spaces in it.
std::string number(const std::string& text) { return "<span class=\"number\">" + text + "</span>"; }
std::string number(std::uint64_t n) { return number(grouped(n)); }

// Returns "2026-03-01 09:30 UTC".
std::string minute(std::chrono::system_clock::time_point time) {
  const std::time_t seconds = std::chrono::system_clock::to_time_t(time);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 64> buffer;
  return std::string(buffer.data(), std::strftime(buffer.data(), buffer.size(), "%Y-%m-%d %H:%M UTC", &parts));
}

std::string facts(const ReportData& data) {
  std::string html = "<dl class=\"facts\">\n";
  const auto fact = [&](const char* name, const std::string& value) {
    html += std::string("<dt>") + name + "</dt><dd>" + value + "</dd>\n";
  };
  const auto along = [&](const char* axis, int i) {
    return number(std::string(axis) + " " + coordinate(data.bounds.lo[i]) + " to " + coordinate(data.bounds.hi[i]));
  };
  fact("finished", number(minute(data.finished)));
  fact("coordinate system", data.crs_title.empty() ? "none in the input" : escape_html(data.crs_title));
  if (!data.bounds.empty())
    fact("box", along("x", 0) + ", " + along("y", 1) + (data.summary.dimension == 3 ? ", " + along("z", 2) : ""));
  if (!data.bounds.empty()) {
    std::string extent;
    for (int i = 0; i < data.summary.dimension; ++i)
      extent += (i > 0 ? " by " : "") + number(coordinate(data.bounds.hi[i] - data.bounds.lo[i]));
    fact("extent", extent);
  }
  if (data.period.any()) {
    std::string periods;
    constexpr std::array axes{"x", "y", "z"};
    for (int i = 0; i < data.summary.dimension; ++i)
      if (data.period.along(i))
        periods += (periods.empty() ? "" : ", ") + number(axes[static_cast<std::size_t>(i)] + std::string(" ") +
                                                          coordinate(data.period.length[static_cast<std::size_t>(i)]));
    fact("period", periods);
  }
  if (data.heights)
    fact("heights", number("z " + coordinate((*data.heights)[0]) + " to " + coordinate((*data.heights)[1])));
  if (!data.summary.digest.empty()) fact("digest", "<code>" + escape_html(data.summary.digest) + "</code>");
  std::string command;
  for (const auto& word : data.command) {
    const auto safe = escape_html(word);
    // so that no line is broken at --
    command += (command.empty() ? "" : " ") + (word.starts_with("--") ? number(safe) : safe);
  }
  fact("command", "<code>" + command + "</code>");
  html += "</dl>\n";
  for (const auto& warning : data.summary.warnings) {
    html += "<p class=\"warning\">" + escape_html(warning) + "</p>\n";
  }
  return html;
}

std::string card(const std::string& value, const std::string& name) {
  return "<div class=\"card\"><b>" + value + "</b><span>" + name + "</span></div>\n";
}

std::string cards(const JobSummary& s) {
  std::string html = "<div class=\"cards\">\n";
  html += card(grouped(s.points_read), "points read");
  html += card(grouped(s.vertices), "vertices");
  html += card(grouped(s.cells), s.dimension == 3 ? "tetrahedra" : "triangles");
  html += card(grouped(s.duplicates), "duplicates");
  if (s.other_heights.value_or(0) > 0)
    html += card(grouped(*s.other_heights), "of them at other heights, the " + std::string(name_of(s.keep)) + " kept");
  if (s.invalid > 0) html += card(grouped(s.invalid), "invalid, skipped");
  if (s.filtered > 0) html += card(grouped(s.filtered), "filtered out");
  html += card(grouped(s.tiles), s.tiles == 1 ? "tile" : "tiles");
  html += card(human_seconds(s.total_s), "on " + std::to_string(s.threads) + (s.threads == 1 ? " thread" : " threads"));
  html += card(human_count(s.total_s > 0 ? static_cast<std::uint64_t>(static_cast<double>(s.vertices) / s.total_s) : 0),
               "vertices a second");
  html += card(human_bytes(s.peak_memory_bytes), "memory at most, of " + human_bytes(s.memory_budget_bytes));
  html += card(human_bytes(s.result_bytes), "result");
  return html + "</div>\n";
}

std::string exchange(const JobSummary& s) {
  const ExchangeFigures& e = s.exchange;
  if (s.tiles == 1) return "<p>There is one tile, which has nobody to exchange points with.</p>\n";
  const auto times = [](std::uint64_t n) { return number(n) + (n == 1 ? " time" : " times"); };
  const auto share = [&](std::uint64_t n) {
    return s.vertices == 0
               ? std::string()
               : " (" + number(fixed(100.0 * static_cast<double>(n) / static_cast<double>(s.vertices), 2) + " %") +
                     " of the vertices)";
  };
  std::string nodes;
  if (e.nodes > 1 || e.nodes_lost > 0) {
    nodes = " " + number(e.nodes) + " nodes sent each other " + human_bytes(e.bytes_between);
    if (e.nodes_lost > 0)
      nodes += "; " + number(e.nodes_lost) + (e.nodes_lost == 1 ? " was" : " were") + " lost, and " +
               number(e.tiles_again) + (e.tiles_again == 1 ? " tile" : " tiles") + " begun again";
    nodes += ".";
  }
  return "<p>" + number(e.updates) + (e.updates == 1 ? " message" : " messages") + " carried " + number(e.points.sent) +
         (e.points.sent == 1 ? " point" : " points") + share(e.points.sent) + ". Tiles received " +
         number(e.points.received) + ", repeats counted, and no tile more than " + number(e.most_received) +
         ". With the points that they know from the start, they inserted " + number(e.points.inserted) +
         " points of other tiles and kept " + number(e.points.useful) +
         ". The longest chain of messages that caused one another: " + number(e.hops) +
         "; the counters were collected " + times(e.waves) + "; tiles were put to sleep " + times(e.sleeps) + "." +
         nodes + "</p>\n";
}

std::string phases(const JobSummary& s) {
  double sum = 0;
  for (const auto& phase : s.seconds) sum += phase.second;
  std::string bar = "<div class=\"phases\">", key = "<div class=\"key\">";
  for (const auto& [name, seconds] : s.seconds) {
    const auto safe = escape_html(name), plain = escape_html(plain_phase(name));
    bar += "<div class=\"p-" + safe + "\" style=\"flex:" + fixed(sum > 0 ? seconds / sum : 1, 5) + "\" title=\"" +
           plain + ": " + human_seconds(seconds) + "\"></div>";
    key += "<span><i class=\"p-" + safe + "\"></i>" + plain + " " + number(human_seconds(seconds)) + "</span>";
  }
  return bar + "</div>\n" + key + "</div>\n";
}

std::string pictures(const ReportData& data) {
  std::vector<double> sizes, seconds;
  for (const auto& tile : data.tiles) {
    sizes.push_back(static_cast<double>(tile.points));
    seconds.push_back(tile.seconds);
  }
  const auto points_of = [](double value) { return grouped(static_cast<std::uint64_t>(value)); };
  const auto figure = [&](int across, int up, const std::string& view, bool by_time) {
    const auto& values = by_time ? seconds : sizes;
    const auto text = [&](double value) { return number(by_time ? human_seconds(value) : points_of(value)); };
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const auto svg = tiles_svg(data, across, up, values);
    if (svg.empty()) return svg;
    return "<figure class=\"panel\"><figcaption>" + view + ", coloured by " + (by_time ? "time worked" : "points") +
           ": " + text(*low) + " to " + text(*high) + " a tile</figcaption>\n" + svg +
           "<div class=\"scale\">0<i style=\"background:" + palette_gradient() + "\"></i>" + text(*high) +
           "</div></figure>\n";
  };
  std::string html =
      "<div class=\"pictures\">\n" + figure(0, 1, "From above (x, y)", false) + figure(0, 1, "From above (x, y)", true);
  // From above, tiles that lie over one another hide each other. So they are also shown from the front.
  const bool stacked =
      data.summary.dimension == 3 && std::any_of(data.tiles.begin(), data.tiles.end(), [&](const auto& t) {
        return t.box.lo.z > data.bounds.lo.z || t.box.hi.z <= data.bounds.hi.z;
      });
  if (stacked) {
    html += figure(0, 2, "From the front (x, z)", false) + figure(0, 2, "From the front (x, z)", true);
  }
  return html + "</div>\n";
}

std::string table(const ReportData& data) {
  auto tiles = data.tiles;
  std::stable_sort(tiles.begin(), tiles.end(), [](const auto& a, const auto& b) { return a.seconds > b.seconds; });
  std::string html;
  if (tiles.size() > table_rows_max) {
    html += "<p class=\"soft\">The " + grouped(table_rows_max) + " that took longest, of " + grouped(tiles.size()) +
            ".</p>\n";
    tiles.resize(table_rows_max);
  }
  html +=
      "<div class=\"panel\"><table><tr><th>tile</th><th>points</th><th>cells</th><th>file</th><th>time "
      "worked</th></tr>\n";
  for (const auto& tile : tiles) {
    html += "<tr><td>" + to_string(tile.tile) + "</td><td>" + grouped(tile.points) + "</td><td>" + grouped(tile.cells) +
            "</td><td>" + human_bytes(tile.bytes) + "</td><td>" + human_seconds(tile.seconds) + "</td></tr>\n";
  }
  return html + "</table></div>\n";
}

}  // namespace

std::string html_report(const ReportData& data) {
  std::string inputs;
  constexpr std::size_t inputs_shown = 8;
  for (std::size_t i = 0; i < std::min(inputs_shown, data.inputs.size()); ++i) {
    inputs += (i > 0 ? ", " : "") + escape_html(std::filesystem::path(data.inputs[i]).filename().string());
  }
  if (data.inputs.size() > inputs_shown) inputs += " and " + grouped(data.inputs.size() - inputs_shown) + " more";

  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Tessera: " +
      inputs + "</title>\n" + report_style() + "</head><body><main>\n";
  html += "<h1>" + inputs + "</h1>\n<p class=\"soft\">Delaunay triangulation in " +
          std::to_string(data.summary.dimension) + "D, " + escape_html(data.partition_kind) + " partition, Tessera " +
          escape_html(data.version) + "</p>\n";
  html += facts(data) + cards(data.summary);
  html += "<h2>Time</h2>\n<div class=\"panel\">" + phases(data.summary) +
          timeline_svg(data.spans, data.summary.total_s) + "</div>\n";
  html += "<h2>Exchange between tiles</h2>\n" + exchange(data.summary);
  if (data.boxes_disjoint && !data.tiles.empty()) html += "<h2>Tiles</h2>\n" + pictures(data);
  if (!data.tiles.empty()) html += "<h2>All tiles, the slowest first</h2>\n" + table(data);
  return html + "</main></body></html>\n";
}

Status write_html_report(const std::filesystem::path& path, const ReportData& data) {
  return write_whole(path, html_report(data));
}

}  // namespace tessera

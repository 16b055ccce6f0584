#include "src/report/html_report.h"

#include <algorithm>

#include "src/files/whole_file.h"
#include "src/report/human.h"

namespace tessera {
namespace {

constexpr std::size_t table_rows_max = 1000;

constexpr const char* style = R"(<style>
:root { color-scheme: light dark; --ink:#1d2430; --soft:#5d6878; --paper:#fbfbf9; --card:#ffffff; --line:#dfe3e8;
  --routing:#8a94a6; --triangulating:#2f6db5; --splaying:#e08a2c; --collecting:#3d9a6a; --finishing:#8a63b0; }
@media (prefers-color-scheme: dark) { :root { --ink:#e4e8ee; --soft:#98a3b3; --paper:#14181f; --card:#1c222b;
  --line:#323a46; --routing:#7d8798; --triangulating:#5b9be0; --splaying:#f0a04b; --collecting:#58bd88; --finishing:#ab88d0; } }
* { box-sizing:border-box }
body { margin:0; background:var(--paper); color:var(--ink); font:15px/1.5 system-ui,sans-serif }
main { max-width:1060px; margin:0 auto; padding:32px 24px 64px }
h1 { font-size:26px; font-weight:650; margin:0 0 4px; letter-spacing:-.01em }
h2 { font-size:17px; font-weight:650; margin:36px 0 10px }
p { margin:0 0 8px } .soft { color:var(--soft) }
code { font:13px/1.5 ui-monospace,monospace; overflow-wrap:anywhere }
.cards { display:grid; grid-template-columns:repeat(auto-fill,minmax(158px,1fr)); gap:10px; margin:20px 0 }
.card { background:var(--card); border:1px solid var(--line); border-radius:8px; padding:10px 14px }
.card b { display:block; font-size:20px; font-weight:600; font-variant-numeric:tabular-nums }
.card span { color:var(--soft); font-size:13px }
.panel { background:var(--card); border:1px solid var(--line); border-radius:8px; padding:14px; overflow-x:auto }
.phases { display:flex; height:26px; border-radius:6px; overflow:hidden; margin-bottom:8px }
.phases div { min-width:1px }
.key { display:flex; flex-wrap:wrap; gap:4px 18px; font-size:13px; color:var(--soft); margin-bottom:10px }
.key i { display:inline-block; width:11px; height:11px; border-radius:3px; margin-right:6px }
.pictures { display:grid; grid-template-columns:repeat(auto-fill,minmax(min(100%,420px),1fr)); gap:16px }
.pictures figure { margin:0 }
figcaption { font-size:13px; color:var(--soft); margin-bottom:8px }
svg { display:block; width:100%; height:auto }
svg text.axis { font:11px system-ui,sans-serif; fill:var(--soft) }
svg .tick { stroke:var(--line); stroke-width:1 }
svg.tiles rect { stroke:var(--card); stroke-width:1; fill-opacity:.86; vector-effect:non-scaling-stroke }
svg.tiles rect.legend { stroke:none; fill-opacity:1 }
svg rect:hover { fill-opacity:1; filter:brightness(1.15) }
)";

const char* const phase_names[] = {"routing", "triangulating", "splaying", "collecting", "finishing"};

std::string phase_styles() {
  std::string css;
  for (const auto* name : phase_names) {
    css += ".p-" + std::string(name) + " { fill:var(--" + name + "); background:var(--" + name + ") }\n";
  }
  return css +
         "table { border-collapse:collapse; width:100%; font-size:13.5px; font-variant-numeric:tabular-nums }\n"
         "th,td { text-align:right; padding:4px 10px; border-bottom:1px solid var(--line) }\n"
         "th { color:var(--soft); font-weight:500 } th:first-child,td:first-child { text-align:left }\n</style>\n";
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
  if (s.invalid > 0) html += card(grouped(s.invalid), "invalid, skipped");
  if (s.filtered > 0) html += card(grouped(s.filtered), "filtered out");
  html += card(grouped(s.tiles), "tiles");
  html += card(human_seconds(s.total_s), "on " + std::to_string(s.threads) + (s.threads == 1 ? " thread" : " threads"));
  html += card(human_count(s.total_s > 0 ? static_cast<std::uint64_t>(static_cast<double>(s.vertices) / s.total_s) : 0),
               "vertices a second");
  html += card(human_bytes(s.peak_memory_bytes), "memory at most, of " + human_bytes(s.memory_budget_bytes));
  html += card(human_bytes(s.result_bytes), "result");
  return html + "</div>\n";
}

std::string exchange(const JobSummary& s) {
  const ExchangeFigures& e = s.exchange;
  const auto share = [&](std::uint64_t n) {
    return s.vertices == 0 ? std::string()
                           : " (" + fixed(100.0 * static_cast<double>(n) / static_cast<double>(s.vertices), 2) +
                                 " % of the vertices)";
  };
  return "<p>" + grouped(e.batches) + " messages carried " + grouped(e.points.sent) + " points" + share(e.points.sent) +
         ". Of " + grouped(e.points.received) + " received, " + grouped(e.points.inserted) + " were inserted and " +
         grouped(e.points.kept) + " kept. The longest chain of messages that caused one another: " + grouped(e.rounds) +
         "; the counters were collected " + grouped(e.waves) + " times; tiles were put to sleep " + grouped(e.sleeps) +
         " times.</p>\n";
}

std::string phases(const JobSummary& s) {
  double sum = 0;
  for (const auto& phase : s.seconds) sum += phase.second;
  std::string bar = "<div class=\"phases\">", key = "<div class=\"key\">";
  for (const auto& [name, seconds] : s.seconds) {
    const auto safe = escape_html(name);
    bar += "<div class=\"p-" + safe + "\" style=\"flex:" + fixed(sum > 0 ? seconds / sum : 1, 5) + "\" title=\"" +
           safe + ": " + human_seconds(seconds) + "\"></div>";
    key += "<span><i class=\"p-" + safe + "\"></i>" + safe + " " + human_seconds(seconds) + "</span>";
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
  const auto figure = [&](int across, int up, const std::string& caption, bool by_time) {
    const auto& values = by_time ? seconds : sizes;
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    const auto svg = tiles_svg(data, across, up, values, by_time ? human_seconds(*low) : points_of(*low),
                               by_time ? human_seconds(*high) : points_of(*high));
    return svg.empty() ? ""
                       : "<figure class=\"panel\"><figcaption>" + caption + "</figcaption>\n" + svg + "</figure>\n";
  };
  std::string html = "<div class=\"pictures\">\n" + figure(0, 1, "From above (x, y), coloured by points", false) +
                     figure(0, 1, "From above (x, y), coloured by time worked", true);
  // From above, tiles over one another hide each other: show them from the front too.
  const bool stacked =
      data.summary.dimension == 3 && std::any_of(data.tiles.begin(), data.tiles.end(), [&](const auto& t) {
        return t.box.lo.z > data.bounds.lo.z || t.box.hi.z <= data.bounds.hi.z;
      });
  if (stacked) {
    html += figure(0, 2, "From the front (x, z), coloured by points", false) +
            figure(0, 2, "From the front (x, z), coloured by time worked", true);
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
  std::string command, inputs;
  for (const auto& word : data.command) command += (command.empty() ? "" : " ") + word;
  constexpr std::size_t inputs_shown = 8;
  for (std::size_t i = 0; i < std::min(inputs_shown, data.inputs.size()); ++i) {
    inputs += (i > 0 ? ", " : "") + escape_html(std::filesystem::path(data.inputs[i]).filename().string());
  }
  if (data.inputs.size() > inputs_shown) inputs += " and " + grouped(data.inputs.size() - inputs_shown) + " more";

  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Tessera: " +
      inputs + "</title>\n" + style + phase_styles() + "</head><body><main>\n";
  html += "<h1>" + inputs + "</h1>\n<p class=\"soft\">Delaunay triangulation in " +
          std::to_string(data.summary.dimension) + "D, " + escape_html(data.partition_kind) + " partition, Tessera " +
          escape_html(data.version) + "</p>\n<p><code>" + escape_html(command) + "</code></p>\n";
  html += cards(data.summary);
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

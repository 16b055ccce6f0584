// report.html: one file without network or scripts from elsewhere, that shows how a job went.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/job/report/summary.h"

namespace tessera {

struct TileFigures {
  TileId tile;
  Box box;  // may be unbounded
  std::uint64_t points = 0, cells = 0, bytes = 0;
  double seconds = 0;  // worked on it
};

struct ReportData {
  JobSummary summary;
  std::string version;
  std::vector<std::string> command;
  std::vector<std::string> inputs;
  std::string crs_title;  // for people; "": none
  std::chrono::system_clock::time_point finished;
  std::string partition_kind;
  bool boxes_disjoint = true;                    // false for the random partition: no picture of tiles then
  Bounds bounds;                                 // of all points
  std::optional<std::array<double, 2>> heights;  // 2D: the least and the greatest, if the vertices have any
  std::vector<TileFigures> tiles;                // that hold points
  std::vector<PhaseSpan> spans;
};

std::string html_report(const ReportData& data);
// Under a temporary name first.
Status write_html_report(const std::filesystem::path& path, const ReportData& data);

// Rows for threads, time to the right, coloured by phase. Spans closer than a pixel are drawn as one. Times are places
// in per cent, so that text keeps its size at any width. Empty when there are no spans.
std::string timeline_svg(const std::vector<PhaseSpan>& spans, double total_s);

// The boxes of the tiles, clipped to the bounds, seen along the axis that is neither `across` nor `up`, each coloured
// by its value in `values` (by position in `tiles`), from 0 to the greatest: tiles that hardly differ look alike.
std::string tiles_svg(const ReportData& data, int across, int up, const std::vector<double>& values);
std::string palette_gradient();  // the colours from 0 to the greatest, for CSS

}  // namespace tessera

// report.html: one file, without network or external scripts, that shows how a job went.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "src/base/image.h"
#include "src/base/point.h"
#include "src/base/progress.h"
#include "src/base/result.h"
#include "src/job/report/summary.h"

namespace tessera {

struct TileFigures {
  TileId tile;
  Box box;  // may be unbounded
  std::uint64_t points = 0, cells = 0, bytes = 0;
  double seconds = 0;  // time that threads worked on it
};

struct ReportData {
  JobSummary summary;
  std::string version;
  std::vector<std::string> command;
  std::vector<std::string> inputs;
  std::string crs_title;  // for people; "": none
  std::chrono::system_clock::time_point finished;
  std::string partition_kind;
  bool boxes_disjoint = true;                    // false for the random partition: then there is no picture of tiles
  Bounds bounds;                                 // of all points
  Period period;                                 // of the space
  std::optional<std::array<double, 2>> heights;  // 2D: the least and the greatest height, if the vertices have heights
  std::vector<TileFigures> tiles;                // tiles that hold points
  std::vector<PhaseSpan> spans;
};

std::string html_report(const ReportData& data);
// Writes the report under a temporary name, then renames it.
Status write_html_report(const std::filesystem::path& path, const ReportData& data);

// Draws a row for each thread, with time to the right, coloured by phase. Spans closer than a pixel are drawn as one.
// Times are positions in per cent, so text keeps its size at any width. Empty when there are no spans.
std::string timeline_svg(const std::vector<PhaseSpan>& spans, double total_s);

// Draws the boxes of the tiles, clipped to the bounds, seen along the axis that is neither `across` nor `up`. Each tile
// is coloured by its value in `values` (beside data.tiles), on a scale from 0 to the greatest value, so tiles that
// hardly differ look alike.
std::string tiles_svg(const ReportData& data, int across, int up, const std::vector<double>& values);
std::string palette_gradient();  // the colours from 0 to the greatest, for CSS

}  // namespace tessera

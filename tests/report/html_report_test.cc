#include "src/job/report/html_report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace tessera {
namespace {

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

ReportData two_tiles() {
  ReportData data;
  data.summary.vertices = 30;
  data.summary.seconds = {{"routing", 0.5}, {"triangulating", 1.5}};
  data.summary.total_s = 2;
  data.command = {"tessera", "<script>"};
  data.inputs = {"/data/a&b.las"};
  data.bounds.add(Point{0, 0, 0});
  data.bounds.add(Point{10, 10, 5});
  TileFigures left, right;
  left.box.hi.x = 5;
  left.points = 10;
  right.tile = TileId{1};
  right.box.lo.x = 5;
  right.points = 20;
  data.tiles = {left, right};
  data.spans = {{Phase::triangulating, 0, 0, 0.5, 1.0}, {Phase::triangulating, 1, 1, 0.5, 2.0}};
  return data;
}

TEST(HtmlReport, IsOneFileWithoutNetworkOrScripts) {
  const auto html = html_report(two_tiles());
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_TRUE(html.starts_with("<!doctype html>"));
  EXPECT_EQ(occurrences(html, "<svg"), occurrences(html, "</svg>"));
}

TEST(HtmlReport, NamesOfFilesAreTextNotMarkup) {
  const auto html = html_report(two_tiles());
  EXPECT_NE(html.find("a&amp;b.las"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;"), std::string::npos);
}

TEST(HtmlReport, SaysWhenWhereAndWhatWasTriangulated) {
  auto data = two_tiles();
  data.crs_title = "RGF93 v1 / Lambert-93 (EPSG:2154)";
  data.finished = std::chrono::system_clock::time_point(std::chrono::seconds(1'000'000'000));
  data.summary.digest = "9535ea8d9011370510168a5be59e9e6e";
  data.summary.warnings = {"a<b: no coordinate system"};
  const auto html = html_report(data);
  for (const char* text : {"RGF93 v1 / Lambert-93 (EPSG:2154)", "2001-09-09 01:46 UTC", "x 0 to 10", "y 0 to 10",
                           "z 0 to 5", "9535ea8d9011370510168a5be59e9e6e", "a&lt;b: no coordinate system"}) {
    EXPECT_NE(html.find(text), std::string::npos) << text;
  }
  EXPECT_EQ(html.find("<dt>period</dt>"), std::string::npos);
  data.period = {{10, 0, 5.5}};
  EXPECT_NE(
      html_report(data).find("<dt>period</dt><dd><span class=\"number\">x 10</span>, <span class=\"number\">z 5.5"),
      std::string::npos);
  data.crs_title.clear();
  data.summary.dimension = 2;
  data.heights = {170.25, 215};
  data.summary.duplicates = 12;
  data.summary.other_heights = 7;
  data.summary.keep = DuplicatePolicy::lowest;
  const auto plane = html_report(data);
  for (const char* text : {"z 170.25 to 215", ">10</span> by <span class=\"number\">10</span>",
                           "<b>7</b><span>of them at other heights, the lowest kept"})
    EXPECT_NE(plane.find(text), std::string::npos) << text;
  EXPECT_NE(plane.find("none in the input"), std::string::npos);
  EXPECT_EQ(plane.find("z 0 to 5"), std::string::npos);
}

// A scale from the least to the greatest would show a difference of 0.6 % as black and white.
TEST(HtmlReport, TilesThatHardlyDifferLookAlike) {
  const auto data = two_tiles();
  const auto fills = [&](double a, double b) {
    const auto svg = tiles_svg(data, 0, 1, {a, b});
    std::vector<std::array<double, 3>> colours;
    for (auto at = svg.find("rgb("); at != std::string::npos; at = svg.find("rgb(", at + 1)) {
      std::array<double, 3> c{};
      EXPECT_EQ(std::sscanf(svg.c_str() + at, "rgb(%lf,%lf,%lf)", &c[0], &c[1], &c[2]), 3);
      colours.push_back(c);
    }
    EXPECT_EQ(colours.size(), 2u);
    double difference = 0;
    for (std::size_t i = 0; i < 3; ++i) difference = std::max(difference, std::abs(colours[0][i] - colours[1][i]));
    return difference;
  };
  EXPECT_LE(fills(994, 1000), 4);
  EXPECT_GE(fills(500, 1000), 100);
  EXPECT_EQ(fills(0, 0), 0);
}

TEST(HtmlReport, CallsThePhasesAsTheSummaryDoes) {
  auto data = two_tiles();
  data.summary.seconds = {{"routing", 0.5}, {"triangulating", 1}, {"splaying", 1}, {"collecting", 0.5}};
  data.spans.push_back({Phase::splaying, 0, 0, 1.0, 1.5});
  const auto html = html_report(data);
  for (const char* text : {"</i>reading ", "</i>joining tiles ", "</i>writing ", "<title>joining tiles, tile 0"})
    EXPECT_NE(html.find(text), std::string::npos) << text;
  for (const char* text : {">routing", ">splaying", ">collecting", "\"routing", "<title>splaying"})
    EXPECT_EQ(html.find(text), std::string::npos) << text;
}

TEST(HtmlReport, HasAColourForEachPhaseThatItShows) {
  const auto html = html_report(two_tiles());
  for (const char* text : {"--routing:#8a94a6;", "--splaying:#f0a04b;", "--finishing:#ab88d0;",
                           ".p-collecting { fill:var(--collecting); background:var(--collecting) }"})
    EXPECT_EQ(occurrences(html, text), 1u) << text;
  EXPECT_EQ(html.find("p-planning"), std::string::npos);
  EXPECT_EQ(html.find("p-done"), std::string::npos);
}

TEST(HtmlReport, TellsOfTheExchangeWithoutRiddles) {
  auto data = two_tiles();
  data.summary.tiles = 2;
  data.summary.exchange.updates = 1;
  data.summary.exchange.points = {.received = 2304, .inserted = 2371, .sent = 2304};
  data.summary.exchange.sleeps = 1;
  const auto html = html_report(data);
  EXPECT_NE(html.find("<p><span class=\"number\">1</span> message carried "), std::string::npos) << html;
  EXPECT_NE(html.find("Tiles received <span class=\"number\">2 304</span>, repeats counted"), std::string::npos);
  EXPECT_NE(
      html.find("With the points that they know from the start, they inserted <span class=\"number\">2 371</span>"),
      std::string::npos);
  EXPECT_NE(html.find("put to sleep <span class=\"number\">1</span> time."), std::string::npos);
  data.summary.tiles = 1;
  EXPECT_NE(html_report(data).find("There is one tile, which has nobody to exchange points with."), std::string::npos);
  EXPECT_EQ(summary_text(data.summary).find("messages"), std::string::npos);
  data.summary.tiles = 2;
  EXPECT_NE(summary_text(data.summary).find("messages      1 between tiles, with 2 304 points\n"), std::string::npos);
}

TEST(HtmlReport, NumbersStayInOneLine) {
  auto data = two_tiles();
  data.summary.exchange.points.sent = 1'234'567;
  const auto html = html_report(data);
  EXPECT_NE(html.find("<span class=\"number\">1 234 567</span>"), std::string::npos);
}

TEST(HtmlReport, UnboundedTilesAreClippedToThePoints) {
  const auto data = two_tiles();
  const auto svg = tiles_svg(data, 0, 1, {10, 20});
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("x=\"0.00\" y=\"0.00\" width=\"230.00\" height=\"460.00\""), std::string::npos);
  EXPECT_NE(svg.find("x=\"230.00\" y=\"0.00\" width=\"230.00\" height=\"460.00\""), std::string::npos);
}

TEST(HtmlReport, EveryThreadHasARowInTheTimeline) {
  const auto svg = timeline_svg(two_tiles().spans, 2);
  EXPECT_NE(svg.find("thread 0"), std::string::npos);
  EXPECT_NE(svg.find("thread 1"), std::string::npos);
  EXPECT_EQ(timeline_svg({}, 2), "");
}

TEST(HtmlReport, AMillionSpansStayAFewThousandBars) {
  std::vector<PhaseSpan> spans;
  for (int i = 0; i < 1'000'000; ++i)
    spans.push_back({Phase::splaying, static_cast<std::uint32_t>(i % 9), 0, i * 1e-4, i * 1e-4 + 5e-5});
  EXPECT_LT(timeline_svg(spans, 100).size(), 1u << 20);
}

TEST(HtmlReport, NothingToShowIsNoCrash) {
  EXPECT_FALSE(html_report(ReportData{}).empty());
  ReportData point = two_tiles();
  point.bounds = Bounds{};
  point.bounds.add(Point{1, 1, 1});
  EXPECT_FALSE(html_report(point).empty());
}

TEST(HtmlReport, AFullDiskIsAnIoErrorAndLeavesNothing) {
  const auto status = write_html_report("/dev/full/report.html", two_tiles());
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, Errc::io);
}

}  // namespace
}  // namespace tessera

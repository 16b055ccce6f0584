#include "src/report/html_report.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

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

TEST(HtmlReport, UnboundedTilesAreClippedToThePoints) {
  const auto data = two_tiles();
  const auto svg = tiles_svg(data, 0, 1, {10, 20}, "10", "20");
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
  std::vector<Span> spans;
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

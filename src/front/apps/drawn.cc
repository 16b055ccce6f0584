#include "src/front/apps/drawn.h"

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/base/option.h"
#include "src/front/apps/outcome_fields.h"
#include "src/front/apps/products.h"
#include "src/front/apps/say.h"
#include "src/front/apps/words.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

using Json = nlohmann::ordered_json;

RegionSummary region_of(const Json& outcome) {
  RegionSummary region;
  region.out = text(outcome, "output");
  region.dimension = outcome.at("dimension").get<int>();
  region.vertices = number(outcome, "vertices");
  region.cells = number(outcome, "cells");
  region.final = number(outcome, "final");
  region.complete = outcome.at("complete").get<bool>();
  region.warnings = outcome.at("warnings").get<std::vector<std::string>>();
  region.figures.units = number(outcome, "units");
  region.figures.points = number(outcome, "points");
  region.figures.bytes = number(outcome, "input_bytes");
  region.figures.units_read = number(outcome, "units_read");
  region.figures.points_read = number(outcome, "points_read");
  region.figures.bytes_read = number(outcome, "read_bytes");
  region.figures.rounds = number(outcome, "rounds");
  region.figures.seconds = outcome.at("seconds").get<double>();
  return region;
}

Dem dem_of(const Json& outcome) {
  return {.path = text(outcome, "output"),
          .width = outcome.at("width").get<std::int64_t>(),
          .height = outcome.at("height").get<std::int64_t>(),
          .pixels = number(outcome, "pixels"),
          .left_out = number(outcome, "left_out"),
          .bytes = number(outcome, "bytes"),
          .note = text(outcome, "note")};
}

Contours contours_of(const Json& outcome) {
  return {.path = text(outcome, "output"),
          .lines = number(outcome, "lines"),
          .closed = number(outcome, "closed"),
          .vertices = number(outcome, "vertices"),
          .levels = number(outcome, "levels"),
          .left_out = number(outcome, "left_out"),
          .shorter = number(outcome, "shorter"),
          .bytes = number(outcome, "bytes"),
          .note = text(outcome, "note")};
}

void print_rest(std::uint64_t left_out, const std::string& note) {
  if (left_out > 0) say("%s cells with longer edges or larger circumradii are left out\n", grouped(left_out).c_str());
  if (!note.empty()) say_beside("note: %s\n", note.c_str());
}

}  // namespace

void print_drawn(const RegionSummary& region, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", region_json(region).c_str());
    return;
  }
  if (!output.quiet) {
    say("%s", region_text(region).c_str());
    for (const auto& warning : region.warnings) say_beside("warning: %s\n", warning.c_str());
  }
  // For a daemon's job the sentence is in the job's log.
  if (!region.complete && !region.needed.empty()) say_beside("note: %s\n", render(region.needed, flag_name).c_str());
}

void print_drawn(const Dem& dem, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(dem).c_str());
  } else if (!output.quiet) {
    const auto all = static_cast<std::uint64_t>(dem.width) * static_cast<std::uint64_t>(dem.height);
    say("%s: %s x %s pixels, %s of them without a value, %s\n", dem.path.c_str(),
        grouped(static_cast<std::uint64_t>(dem.width)).c_str(), grouped(static_cast<std::uint64_t>(dem.height)).c_str(),
        grouped(all - dem.pixels).c_str(), human_bytes(dem.bytes).c_str());
    print_rest(dem.left_out, dem.note);
  }
}

void print_drawn(const Contours& contours, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(contours).c_str());
  } else if (!output.quiet) {
    say("%s: %s, %s of them closed, at %s, %s vertices, %s\n", contours.path.c_str(),
        counted(contours.lines, "line").c_str(), grouped(contours.closed).c_str(),
        counted(contours.levels, "level").c_str(), grouped(contours.vertices).c_str(),
        human_bytes(contours.bytes).c_str());
    if (contours.shorter > 0) say("%s shorter lines are left out\n", grouped(contours.shorter).c_str());
    print_rest(contours.left_out, contours.note);
  }
}

bool print_drawn(const Json& outcome, const OutputOptions& output) {
  try {
    const std::string event = text(outcome, "event");
    if (event == "dem") {
      print_drawn(dem_of(outcome), output);
    } else if (event == "contours") {
      print_drawn(contours_of(outcome), output);
    } else if (event == "finished" && outcome.contains("units_read")) {
      print_drawn(region_of(outcome), output);
    } else {
      return print_product(outcome, output);
    }
    return true;
  } catch (const Json::exception&) {  // a daemon of another version has other fields
    return false;
  }
}

}  // namespace tessera::apps

#include "src/front/apps/products.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "src/base/json/json_text.h"
#include "src/front/apps/outcome_fields.h"
#include "src/front/apps/say.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

using Json = nlohmann::ordered_json;

AlphaShape alpha_of(const Json& outcome) {
  return {.path = text(outcome, "output"),
          .radius = outcome.at("radius").get<double>(),
          .searched = outcome.at("searched").get<bool>(),
          .general = outcome.at("general").get<bool>(),
          .cells = number(outcome, "cells"),
          .vertices = number(outcome, "vertices"),
          .facets = number(outcome, "facets"),
          .singular_facets = number(outcome, "singular_facets"),
          .singular_edges = number(outcome, "singular_edges"),
          .singular_vertices = number(outcome, "singular_vertices"),
          .polygons = number(outcome, "polygons"),
          .holes = number(outcome, "holes"),
          .bytes = number(outcome, "bytes"),
          .note = text(outcome, "note")};
}

WrittenVoronoi voronoi_of(const Json& outcome) {
  const int dimension = outcome.at("dimension").get<int>();
  return {.path = text(outcome, "output"),
          .dimension = dimension,
          .cells = number(outcome, "cells"),
          .unbounded = number(outcome, "unbounded"),
          .outside = number(outcome, "outside"),
          .shapeless = number(outcome, "shapeless"),
          .thin = number(outcome, "thin"),
          .duplicates = number(outcome, "duplicates"),
          .size = outcome.at(dimension == 2 ? "area" : "volume").get<double>(),
          .bytes = number(outcome, "bytes"),
          .note = text(outcome, "note")};
}

std::string digits_of(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.17g", number);
  return text.data();
}

density::GridFile grid_of(const Json& outcome) {
  density::GridFacts facts;
  const Json& size = outcome.at("size");
  facts.dimension = size.size() == 2 ? 2 : 3;
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis)
    facts.size[axis] = size.at(axis).get<std::int64_t>();
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis)
    facts.widths[axis] = outcome.at("widths").at(axis).get<double>();
  facts.known = number(outcome, "known");
  const auto mass = [&](const char* key) {
    const Json& value = outcome.at(key);
    return value.is_null() ? std::optional<double>() : value.get<double>();
  };
  facts.mass = mass("mass");
  facts.grid_mass = mass("grid_mass");
  facts.note = text(outcome, "note");
  return {.path = text(outcome, "output"), .facts = facts, .bytes = number(outcome, "bytes")};
}

// Of the rows only as much as is printed.
Volumes volumes_of(const Json& outcome) {
  Volumes volumes;
  for (const Json& row : outcome.at("rows")) {
    volumes.rows.emplace_back();
    volumes.polygons = row.contains("polygon");
  }
  volumes.long_edges = number(outcome, "long_edges");
  volumes.without_height = number(outcome, "without_height");
  volumes.note = text(outcome, "note");
  return volumes;
}

}  // namespace

void print_product(const AlphaShape& shape, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(shape).c_str());
    return;
  }
  if (output.quiet) return;
  const std::string file = shape.path.string() + ": " + counted(shape.cells, "cell") + " of a circumradius up to " +
                           radius_text(shape.radius) + ", ";
  if (shape.polygons > 0) {
    say("%s%s with %s, %s vertices, %s\n", file.c_str(), counted(shape.polygons, "polygon").c_str(),
        counted(shape.holes, "hole").c_str(), grouped(shape.vertices).c_str(), human_bytes(shape.bytes).c_str());
  } else {
    say("%s%s on the boundary, %s vertices, %s\n", file.c_str(), counted(shape.facets, "facet").c_str(),
        grouped(shape.vertices).c_str(), human_bytes(shape.bytes).c_str());
  }
  if (shape.general)
    say("singular: %s, %s, %s vertices\n", counted(shape.singular_facets, "facet").c_str(),
        counted(shape.singular_edges, "edge").c_str(), grouped(shape.singular_vertices).c_str());
  if (!shape.note.empty()) say_beside("note: %s\n", shape.note.c_str());
}

void print_product(const density::GridFile& file, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(file).c_str());
    return;
  }
  if (output.quiet) return;
  const density::GridFacts& facts = file.facts;
  std::string sides, widths;  // of widths that are all the same, one
  std::uint64_t all = 1;
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(facts.dimension); ++axis) {
    const auto side = static_cast<std::uint64_t>(facts.size[axis]);
    sides += (sides.empty() ? "" : " x ") + grouped(side);
    if (axis == 0 || facts.widths[axis] != facts.widths[0])
      widths += (widths.empty() ? "" : " x ") + digits_of(facts.widths[axis]);
    all *= side;
  }
  say("%s: %s %s of width %s, %s of them without a value, %s\n", file.path.c_str(), sides.c_str(),
      facts.dimension == 2 ? "pixels" : "voxels", widths.c_str(), grouped(all - facts.known).c_str(),
      human_bytes(file.bytes).c_str());
  if (facts.mass && facts.grid_mass)
    say("mass of all points: %.17g, of the grid: %.17g\n", *facts.mass, *facts.grid_mass);
  if (!facts.note.empty()) say_beside("note: %s\n", facts.note.c_str());
}

void print_product(const WrittenVoronoi& written, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(written).c_str());
    return;
  }
  if (output.quiet) return;
  const bool flat = written.dimension == 2;
  say("%s: %s, %s together %.17g, %s\n", written.path.c_str(), counted(written.cells, "cell").c_str(),
      flat ? "areas" : "volumes", written.size, human_bytes(written.bytes).c_str());
  if (written.unbounded > 0) say("%s of them are unbounded as a whole\n", grouped(written.unbounded).c_str());
  if (written.outside > 0) say("%s do not meet the clip and are left out\n", counted(written.outside, "cell").c_str());
  if (written.shapeless > 0)
    say(flat ? "%s have no polygon\n" : "%s have no polyhedron and are left out\n",
        counted(written.shapeless, "cell").c_str());
  if (written.thin > 0)
    say("%s have parts that are thinner than the coordinates resolve; these parts are left out\n",
        counted(written.thin, "cell").c_str());
  if (written.duplicates > 0)
    say("%s of other points have no cell of their own\n", counted(written.duplicates, "duplicate").c_str());
  if (!written.note.empty()) say_beside("note: %s\n", written.note.c_str());
}

void print_product(const std::string& table, const Volumes& volumes, const OutputOptions& output) {
  if (output.quiet) return;
  if (!table.empty())
    say("%s: %s %s\n", table.c_str(), grouped(volumes.rows.size()).c_str(),
        !volumes.polygons          ? "row"
        : volumes.rows.size() == 1 ? "polygon"
                                   : "polygons");
  if (volumes.long_edges > 0)
    say_beside("note: %s cells with longer edges are left out: holes\n", grouped(volumes.long_edges).c_str());
  if (volumes.without_height > 0)
    say_beside("note: %s cells have a vertex without a height, and are left out: holes\n",
               grouped(volumes.without_height).c_str());
  if (!volumes.note.empty()) say_beside("note: %s\n", volumes.note.c_str());
}

bool print_product(const Json& outcome, const OutputOptions& output) {
  const std::string event = text(outcome, "event");
  const bool known = event == "alpha" || event == "density" || event == "voronoi" || event == "volumes";
  if (known && output.json) {
    Json told = outcome;
    told.erase("written");  // where the daemon had the file
    std::printf("%s\n", json_text(told).c_str());
    return true;
  }
  if (event == "alpha") {
    const AlphaShape shape = alpha_of(outcome);
    print_product(shape, output);
  } else if (event == "density") {
    print_product(grid_of(outcome), output);
  } else if (event == "voronoi") {
    print_product(voronoi_of(outcome), output);
  } else if (event == "volumes") {
    print_product(text(outcome, "output"), volumes_of(outcome), output);
  }
  return known;
}

}  // namespace tessera::apps

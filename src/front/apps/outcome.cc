#include "src/front/apps/outcome.h"

#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "src/front/apps/say.h"
#include "src/front/apps/server_options.h"
#include "src/job/report/human.h"

namespace tessera::apps {
namespace {

using Json = nlohmann::ordered_json;

bool read(const Json& object, const char* key, std::uint64_t& value) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_unsigned()) return false;
  value = found->get<std::uint64_t>();
  return true;
}

bool read(const Json& object, const char* key, std::string& value) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_string()) return false;
  value = found->get<std::string>();
  return true;
}

}  // namespace

void print_verified(const std::string& result, const VerifyReport& report, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(report, result).c_str());
  } else if (!output.quiet) {
    for (const auto& line : report.passed) say("ok  %s\n", line.c_str());
    say("%s is the Delaunay triangulation of its %s vertices: %s cells, %s facets, %s of them on the hull\n",
        result.c_str(), grouped(report.vertices).c_str(), grouped(report.cells).c_str(), grouped(report.facets).c_str(),
        grouped(report.hull_facets).c_str());
  }
}

std::string limits_text(const Settings& settings) {
  std::string text;
  if (const auto edge = settings.text("max-edge")) text = "longer edges than " + *edge;
  if (const auto radius = settings.text("max-radius"))
    text += (text.empty() ? "" : " or ") + ("larger circumradii than " + *radius);
  return text;
}

void print_exported(const Exported& exported, const std::string& limits, const OutputOptions& output) {
  if (output.json) {
    std::printf("%s\n", to_json(exported, exported.path.string()).c_str());
  } else if (!output.quiet) {
    say("%s: %s vertices, %s cells, %s\n", exported.path.c_str(), grouped(exported.vertices).c_str(),
        grouped(exported.cells).c_str(), human_bytes(exported.bytes).c_str());
    if (!limits.empty()) say("%s cells with %s are left out\n", grouped(exported.left_out).c_str(), limits.c_str());
    if (const auto& corner = exported.corner)
      say("coordinates count from %.0f %.0f %.0f\n", corner->x, corner->y, corner->z);
    if (!exported.note.empty()) say_beside("note: %s\n", exported.note.c_str());
  }
}

std::optional<VerifyReport> verified_of(const Json& outcome) {
  VerifyReport report;
  const auto passed = outcome.find("passed");
  if (!read(outcome, "cells", report.cells) || !read(outcome, "facets", report.facets) ||
      !read(outcome, "hull_facets", report.hull_facets) || !read(outcome, "vertices", report.vertices) ||
      passed == outcome.end() || !passed->is_array())
    return std::nullopt;
  for (const auto& line : *passed) {
    if (!line.is_string()) return std::nullopt;
    report.passed.push_back(line.get<std::string>());
  }
  return report;
}

std::optional<Exported> exported_of(const Json& outcome) {
  Exported exported;
  std::string output;
  if (!read(outcome, "output", output) || !read(outcome, "vertices", exported.vertices) ||
      !read(outcome, "cells", exported.cells) || !read(outcome, "left_out", exported.left_out) ||
      !read(outcome, "files", exported.files) || !read(outcome, "bytes", exported.bytes) ||
      !read(outcome, "note", exported.note))
    return std::nullopt;
  exported.path = output;
  if (const auto corner = outcome.find("corner"); corner != outcome.end()) {
    if (!corner->is_array() || corner->size() != 3) return std::nullopt;
    exported.corner.emplace();
    for (int axis = 0; axis < 3; ++axis) {
      const Json& number = (*corner)[static_cast<std::size_t>(axis)];
      if (!number.is_number()) return std::nullopt;
      (*exported.corner)[axis] = number.get<double>();
    }
  }
  return exported;
}

}  // namespace tessera::apps

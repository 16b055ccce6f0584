// Answers one question to an open result. Options are read as the command reads them, and the answer is what the
// command would print.
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/export/export.h"
#include "src/result/query/answers.h"
#include "src/result/query/area.h"
#include "src/result/query/stored_triangulation.h"
#include "src/result/tileset/shapes.h"
#include "src/service/questions/map_features.h"
#include "src/service/questions/questions.h"
#include "src/service/questions/readers.h"
#include "src/service/service.h"

namespace tessera {

class Answering {
 public:
  // `folder` is an empty folder, which is removed after the question. The arguments must stay valid as long as this
  // object.
  Answering(const Reader& reader, const Question& question, const QuestionLimits& limits, std::filesystem::path folder,
            std::stop_token stop);

  // Errors have marks for options, "the body" for the body, and paths for files.
  Result<QuestionAnswer> answer() const;

 private:
  Result<QuestionAnswer> locate() const;
  Result<QuestionAnswer> locate_named() const;  // a cell by its tile and index
  Result<QuestionAnswer> locate_many() const;
  Result<QuestionAnswer> star() const;
  Result<QuestionAnswer> cells() const;
  Result<QuestionAnswer> interpolate() const;
  static QuestionAnswer in_bytes(std::string message, bool final);
  // The answer for a point and its cell, if it has one.
  QuestionAnswer location(const Point& p, const std::optional<query::CellDetails>& details, bool final) const;
  // answering_terrain.cc
  Result<QuestionAnswer> dem() const;
  Result<QuestionAnswer> contours() const;
  Result<QuestionAnswer> profile() const;
  // answering_maps.cc
  Result<QuestionAnswer> features() const;
  Result<MapForm> map_form() const;
  Result<QuestionAnswer> map_tile() const;
  Result<std::vector<Point>> hull_corners() const;
  template <class Options>
  Status read_surface(Options& options) const;
  // answering_cells.cc
  Result<QuestionAnswer> hull() const;
  Result<QuestionAnswer> section() const;
  Result<QuestionAnswer> solids() const;

  std::string word(const std::string& key, const std::string& usual = {}) const;
  template <class Parse>
  auto read(const std::string& key, const Parse& parse) const -> decltype(parse(std::string())) {
    auto value = parse(word(key));
    if (!value) return error(value.error().code, key + ": " + value.error().where);
    return value;
  }
  // answering_points.cc
  Result<std::vector<Point>> points() const;
  Result<std::vector<Point>> points_in_json() const;
  Result<std::vector<Point>> points_in_file(const std::string& ending) const;
  Result<query::Area> area() const;
  // The number of cells that an answer may have.
  Result<query::CellLimits> limits_of_cells() const;
  // Leaves out cells with a longer edge; nothing: leaves out none.
  Result<std::optional<double>> longest_edge() const;
  // The format of the answers to many points: that of the body, or the one that `f` names.
  Result<AnswerOptions> many() const;
  Result<QuestionAnswer> finished(TextAnswers& answers, AnswerFormat format, bool final) const;
  Result<QuestionAnswer> file(const std::filesystem::path& path, bool final) const;
  bool is_part() const { return reader_.stored.manifest().region.has_value(); }
  // Error usage unless the result is 3D; for questions about parts of a 3D result.
  Status has_volume() const;
  Result<QuestionAnswer> shown(const tileset::Shape& shape, const query::CellSet& cells) const;
  std::uint64_t memory_bytes() const { return limits_.memory_bytes / 8; }

  const Reader& reader_;
  const Question& question_;
  const QuestionLimits& limits_;
  const std::filesystem::path folder_;
  const query::AskOptions ask_;
  const int dimension_;
};

}  // namespace tessera

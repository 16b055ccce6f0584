// A question to an open result: its options, its body, and where an answer may be made. Options are read as the command
// reads them, and the answer is what the command would print.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/job/arguments.h"
#include "src/result/export/cell_filter.h"
#include "src/result/query/answers.h"
#include "src/result/query/area.h"
#include "src/result/query/stored_triangulation.h"
#include "src/service/questions/questions.h"
#include "src/service/questions/questions_backend.h"
#include "src/service/questions/readers.h"

namespace tessera {
class LiveVersion;
}

namespace tessera::service {

class OpenQuestion {
 public:
  // `folder` is an empty folder, which is removed after the question. The arguments must stay valid as long as this
  // object.
  OpenQuestion(const Reader& reader, const Question& question, const QuestionLimits& limits,
               std::filesystem::path folder, std::stop_token stop);

  const Reader& reader;
  const Question& question;
  const QuestionLimits& limits;
  const std::filesystem::path folder;
  const query::AskOptions ask;
  const int dimension;
  const LiveVersion* live = nullptr;  // if set, it answers instead of the stored version (live_answers.h)

  // Errors have marks for options, "the body" for the body, and paths for files. Here and below.
  //
  // The text of an option.
  std::string word(const std::string& key, const std::string& usual = {}) const;
  // An option as `parse` reads it.
  template <class Parse>
  auto read(const std::string& key, const Parse& parse) const -> decltype(parse(std::string())) {
    auto value = parse(word(key));
    if (!value) return error(value.error().code, key + ": " + value.error().where);
    return value;
  }
  // The vertex that is asked about, by its source index.
  Result<PointId> vertex() const;
  // The tile that owns the vertex, if the question says it.
  Result<std::optional<TileId>> owner() const;
  // The points of the body: JSON, protobuf, text, NumPy's format, and no other.
  Result<std::vector<Point>> points() const;
  // The box of the options, or the polygon of the body.
  Result<query::Area> area() const;
  // The number of cells that an answer may have.
  Result<query::CellLimits> limits_of_cells() const;
  // The limits of cells; without one in the question there is none.
  Result<exports::CellSizes> sizes() const;
  // The options that questions to a surface have in common.
  template <class Options>
  Status read_surface(Options& options) const {
    BOOST_OUTCOME_TRY(limits, sizes());
    options.max_edge = limits.max_edge;
    options.max_radius = limits.max_radius;
    options.value = word("value", "z");
    if constexpr (requires { options.box; }) {
      if (!question.options.contains("bbox")) return success();
      BOOST_OUTCOME_TRY(box, read("bbox", [](const std::string& text) { return parse_crop(text, 2); }));
      options.box = Bounds{box.lo, box.hi};
    }
    return success();
  }
  // The format of the answers to many points: that of the body, or the one that `f` names.
  Result<AnswerOptions> many() const;
  // Answers with a file.
  Result<QuestionAnswer> file(const std::filesystem::path& path, bool final) const;
  // True if the result is a region, so that its cells end where the triangulation does not.
  bool is_part() const { return reader.stored.manifest().region.has_value(); }
  std::uint64_t memory_bytes() const { return limits.memory_bytes / 8; }

 private:
  Result<std::vector<Point>> points_in_json() const;
  Result<std::vector<Point>> points_in_file(const std::string& ending) const;
};

inline constexpr const char* json_type = "application/json";

// Answers with a message, or with the text of answers to many points.
QuestionAnswer in_bytes(std::string message, bool final);
Result<QuestionAnswer> finished(TextAnswers& answers, AnswerFormat format, bool final);
bool all_final(const auto& answers) {
  for (const auto& answer : answers)
    if (!answer.final) return false;
  return true;
}

}  // namespace tessera::service

// Answers questions to results while their callers wait. Memory, time and the size of answers are bounded.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "src/base/result.h"
#include "src/service/deadline.h"
#include "src/service/questions/collections.h"
#include "src/service/questions/questions_backend.h"
#include "src/service/questions/readers.h"
#include "src/service/results/result_folders.h"

namespace tessera::service {

class LiveResults;

struct QuestionLimits {
  std::uint64_t memory_bytes = std::uint64_t{128} << 20;  // half for open results; a question has a quarter of the rest
  unsigned threads = 1;                                   // for one question
  std::chrono::seconds time = answer_time;
  std::uint64_t points = 1 << 18;  // in one body
  std::uint64_t cells = 1'000'000, usual_cells = 100'000;
  std::uint64_t pixels = 1 << 24;
  std::uint64_t line_vertices = 2'000'000;              // of contour lines
  std::uint64_t answer_bytes = std::uint64_t{2} << 30;  // of files: the answer and its scratch
};

// Thread-safe.
class Questions final : public QuestionsBackend {
 public:
  // `data` is the data folder; answers that are files are kept there. `live`: the results that are kept in memory, if
  // there are any; it outlives this object.
  Questions(ResultFolders& results, std::filesystem::path data, QuestionLimits limits,
            const LiveResults* live = nullptr)
      : results_(results),
        data_(std::move(data)),
        limits_(limits),
        readers_(results, limits.memory_bytes / 2),
        maps_(results),
        live_(live) {}
  // Makes the folder for answers, without old contents.
  Status open();

  Reply<std::string> identity(std::string_view name) override;
  Reply<QuestionAnswer> ask(const Question& question) override;
  Reply<std::vector<FeatureCollection>> collections() override { return maps_.list(); }
  Reply<FeatureCollection> collection(std::string_view id) override { return maps_.find(id); }
  Reply<std::array<double, 4>> map_extent(std::string_view name) override { return maps_.map_extent(name); }
  // Call this when the result is removed or replaced: ends the questions to it.
  void close(std::string_view name) { readers_.close(name); }
  // Call this when the result has got a new version.
  void renew(std::string_view name) { readers_.renew(name); }
  std::size_t open_results() const { return readers_.count(); }

 private:
  ResultFolders& results_;
  const std::filesystem::path data_;
  const QuestionLimits limits_;
  Readers readers_;
  Collections maps_;
  const LiveResults* live_;
};

}  // namespace tessera::service

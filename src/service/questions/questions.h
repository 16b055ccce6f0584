// Answers questions to results while their callers wait. Memory, time and the size of answers are bounded.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/result.h"
#include "src/service/deadline.h"
#include "src/service/questions/readers.h"
#include "src/service/results/result_folders.h"
#include "src/service/service.h"

namespace tessera {

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

class Questions {
 public:
  // `data` is the data folder; answers that are files are kept there.
  Questions(Results& results, std::filesystem::path data, QuestionLimits limits)
      : results_(results), data_(std::move(data)), limits_(limits), readers_(results, limits.memory_bytes / 2) {}
  // Makes the folder for answers, without old contents.
  Status open();

  Reply<std::string> identity(std::string_view name);
  Reply<QuestionAnswer> ask(const Question& question);
  // Call this when the result is removed or replaced: ends the questions to it.
  void close(std::string_view name) { readers_.close(name); }
  std::size_t open_results() const { return readers_.count(); }

 private:
  Results& results_;
  const std::filesystem::path data_;
  const QuestionLimits limits_;
  Readers readers_;
};

}  // namespace tessera

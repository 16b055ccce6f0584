// Questions to results, answered while their caller waits: bounded in memory, time and size of the answer.
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
#include "src/service/readers.h"
#include "src/service/results.h"
#include "src/service/service.h"

namespace tessera {

struct QuestionLimits {
  std::uint64_t memory_bytes = std::uint64_t{128} << 20;  // half for open results; of the rest a quarter a question
  unsigned threads = 1;                                   // of one question
  std::chrono::seconds time = answer_time;
  std::uint64_t points = 1 << 18;  // in one body
  std::uint64_t cells = 1'000'000, usual_cells = 100'000;
  std::uint64_t pixels = 1 << 24;
  std::uint64_t line_vertices = 2'000'000;              // of contour lines
  std::uint64_t answer_bytes = std::uint64_t{2} << 30;  // of files: the answer, and what it takes to make it
};

class Questions {
 public:
  // `data`: where answers wait that are files.
  Questions(Results& results, std::filesystem::path data, QuestionLimits limits)
      : results_(results), data_(std::move(data)), limits_(limits), readers_(results, limits.memory_bytes / 2) {}
  // Makes the folder anew.
  Status open();

  Reply<std::string> identity(std::string_view name);
  Reply<QuestionAnswer> ask(const Question& question);
  // The result is removed or replaced: questions to it end.
  void close(std::string_view name) { readers_.close(name); }
  std::size_t open_results() const { return readers_.count(); }

 private:
  Results& results_;
  const std::filesystem::path data_;
  const QuestionLimits limits_;
  Readers readers_;
};

}  // namespace tessera

// Writes the answers to many questions as CSV, JSON lines or a NumPy array, to a file, standard output or memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/point.h"
#include "src/base/result.h"
#include "src/result/query/stored_triangulation.h"

namespace tessera {

enum class AnswerFormat : std::uint8_t { csv, json, npy };

// The format named by --format (csv, json or npy), or else by the file's ending. Error usage.
Result<AnswerFormat> answer_format(const std::string& name, const std::filesystem::path& target, bool json);

struct AnswerOptions {
  bool values = false;  // values of interpolate(); else cells of locate()
  AnswerFormat format = AnswerFormat::csv;
  int dimension = 3;
  std::filesystem::path target = {};  // empty: standard output
  bool overwrite = false;
  bool weights = false;  // with values: also vertices and their weights
  bool final = false;    // for a region: also whether each holds in the whole triangulation; a column in arrays
};

// Writes answers one after the other. A file appears only when it is complete. A missing value is empty in CSV, -1 or
// NaN in arrays, and null in JSON.
class Answers {
 public:
  // Errors: usage when the file exists, when an array would go to standard output, or for weights in an array; io.
  static Result<std::unique_ptr<Answers>> open(const AnswerOptions& options);
  virtual ~Answers() = default;

  // Rows x,y[,z],tile,cell,v0,...; as an array i8 n x (tile, cell, v0, ...).
  Status add_cells(std::span<const Point> points, std::span<const query::Cell> cells);
  // Rows x,y[,z],value[,vertices,weights]; as an array f8 n.
  Status add_values(std::span<const Point> points, std::span<const query::Interpolated> values);
  // Completes the file. Without this call nothing is left of it.
  virtual Status finish() = 0;

 protected:
  explicit Answers(const AnswerOptions& options) : options_(options) {}
  // The header of an array with `bytes` bytes of data.
  std::string array_head(std::uint64_t bytes) const;
  const AnswerOptions& options() const { return options_; }

 private:
  virtual Status write(std::string_view bytes) = 0;
  // The answer to one point.
  void add(std::string& to, const Point& p, const query::Cell& cell) const;
  void add(std::string& to, const Point& p, const query::Interpolated& value) const;
  void begin_line(std::string& to, const Point& p) const;
  void end_line(std::string& to, bool final) const;
  template <class Answer>
  Status add_all(std::span<const Point> points, std::span<const Answer> answers);

  AnswerOptions options_;
  bool begun_ = false;
};

// Collects answers in memory, for a program that asks for a few at a time.
class TextAnswers final : public Answers {
 public:
  // Error usage for weights in an array.
  static Result<std::unique_ptr<TextAnswers>> make(const AnswerOptions& options);
  Status finish() override;
  // Returns the whole text. REQUIRES: finish() was called.
  std::string take() { return std::move(text_); }

 private:
  explicit TextAnswers(const AnswerOptions& options) : Answers(options) {}
  Status write(std::string_view bytes) override;
  std::string text_;
};

// Appends the shortest digits that are read back as the same number; "null" for what JSON cannot express.
void add_number(std::string& to, double number);

}  // namespace tessera

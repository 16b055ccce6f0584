#include "src/result/query/answers.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <utility>

#include "src/base/files/there.h"
#include "src/base/option.h"
#include "src/result/export/output.h"

namespace tessera {

namespace {

void add_whole(std::string& to, std::int64_t number) { to += std::to_string(number); }

template <class T>
void add_bytes(std::string& to, T value) {
  to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

class ToStandardOutput : public Answers {
 public:
  explicit ToStandardOutput(const AnswerOptions& options) : Answers(options) {}
  Status finish() override { return checked(std::fflush(stdout) == 0); }

 private:
  Status write(std::string_view bytes) override {
    return checked(std::fwrite(bytes.data(), 1, bytes.size(), stdout) == bytes.size());
  }
  static Status checked(bool good) {
    if (good) return success();
    return error(Errc::io, std::string("standard output: cannot be written: ") + std::strerror(errno));
  }
};

// NumPy's header has the number of rows, which is known last. Its place is left out and filled at the end.
constexpr std::size_t header_bytes = 128;

class ToFile : public Answers {
 public:
  ToFile(const AnswerOptions& options, exports::OutputFile file)
      : Answers(options),
        array_(options.format == AnswerFormat::npy),
        file_(std::move(file)),
        stream_(file_, array_ ? header_bytes : 0) {}

  Status finish() override {
    BOOST_OUTCOME_TRYV(stream_.flush());
    if (array_) {
      exports::Stream head(file_, 0);
      head.text(array_head(stream_.offset() - header_bytes));
      BOOST_OUTCOME_TRYV(head.flush());
    }
    BOOST_OUTCOME_TRYV(file_.finish());
    return success();
  }

 private:
  Status write(std::string_view bytes) override {
    stream_.text(bytes);
    return stream_.status();
  }

  bool array_;
  exports::OutputFile file_;
  exports::Stream stream_;
};

Status check(const AnswerOptions& options) {
  if (options.format != AnswerFormat::npy || !options.weights) return success();
  return error(Errc::usage, "a NumPy array holds only values; weights need csv or json");
}

}  // namespace

Result<AnswerFormat> answer_format(const std::string& name, const std::filesystem::path& target, bool json) {
  const std::string ending = target.extension();
  if (name == "csv" || (name.empty() && (ending == ".csv" || ending == ".txt"))) return AnswerFormat::csv;
  if (name == "npy" || (name.empty() && ending == ".npy")) return AnswerFormat::npy;
  if (name == "json" || (name.empty() && (ending == ".json" || ending == ".jsonl" || ending == ".ndjson")))
    return AnswerFormat::json;
  if (name.empty() && target.empty()) return json ? AnswerFormat::json : AnswerFormat::csv;
  return error(Errc::usage, "'" + (name.empty() ? target.string() : name) +
                                "' is no format of answers; there are csv, json (one object a line) and npy");
}

Result<std::unique_ptr<Answers>> Answers::open(const AnswerOptions& options) {
  BOOST_OUTCOME_TRYV(check(options));
  if (options.target.empty()) {
    if (options.format == AnswerFormat::npy)
      return error(Errc::usage, "a NumPy array is not written to standard output; name a file for it");
    return std::unique_ptr<Answers>(std::make_unique<ToStandardOutput>(options));
  }
  BOOST_OUTCOME_TRY(there, is_there(options.target));
  if (there && !options.overwrite)
    return error(Errc::usage,
                 options.target.string() + ": exists already; " + option("overwrite", "true") + " replaces it");
  BOOST_OUTCOME_TRY(file, exports::OutputFile::create(options.target));
  return std::unique_ptr<Answers>(std::make_unique<ToFile>(options, std::move(file)));
}

Result<std::unique_ptr<TextAnswers>> TextAnswers::make(const AnswerOptions& options) {
  BOOST_OUTCOME_TRYV(check(options));
  return std::unique_ptr<TextAnswers>(new TextAnswers(options));
}

Status TextAnswers::write(std::string_view bytes) {
  text_ += bytes;
  return success();
}

Status TextAnswers::finish() {
  if (options().format == AnswerFormat::npy) text_.insert(0, array_head(text_.size()));
  return success();
}

std::string Answers::array_head(std::uint64_t bytes) const {
  const auto columns =
      (options_.values ? 1 : static_cast<std::uint64_t>(options_.dimension) + 3) + (options_.final ? 1 : 0);
  const std::string shape = std::to_string(bytes / 8 / columns) + (columns == 1 ? "," : ", " + std::to_string(columns));
  std::string text = std::string("\x93NUMPY\x01\x00\x76\x00", 10) + "{'descr': '" + (options_.values ? "<f8" : "<i8") +
                     "', 'fortran_order': False, 'shape': (" + shape + "), }";
  text.resize(header_bytes - 1, ' ');
  return text + "\n";
}

Status Answers::add_cells(std::span<const Point> points, std::span<const query::Cell> cells) {
  return add_all(points, cells);
}
Status Answers::add_values(std::span<const Point> points, std::span<const query::Interpolated> values) {
  return add_all(points, values);
}

template <class Answer>
Status Answers::add_all(std::span<const Point> points, std::span<const Answer> answers) {
  std::string text;
  if (!std::exchange(begun_, true) && options_.format == AnswerFormat::csv) {
    text = options_.dimension == 3 ? "x,y,z," : "x,y,";
    text += options_.values ? options_.weights ? "value,vertices,weights" : "value" : "tile,cell,v0,v1,v2";
    text += !options_.values && options_.dimension == 3 ? ",v3" : "";
    text += options_.final ? ",final\n" : "\n";
  }
  for (std::size_t i = 0; i < answers.size(); ++i) add(text, points[i], answers[i]);
  return write(text);
}

void Answers::begin_line(std::string& to, const Point& p) const {
  to += options_.format == AnswerFormat::json ? "{\"point\":[" : "";
  for (int axis = 0; axis < options_.dimension; ++axis) {
    if (axis > 0) to += ',';
    add_number(to, p[axis]);
  }
  to += options_.format == AnswerFormat::json ? "]," : ",";
}

void Answers::add(std::string& to, const Point& p, const query::Cell& cell) const {
  const auto corners = static_cast<std::size_t>(options_.dimension) + 1;
  const auto vertex = [&](std::size_t k) { return cell ? static_cast<std::int64_t>(cell.vertices[k].value) : -1; };
  const auto tile = cell ? static_cast<std::int64_t>(cell.tile.value) : -1;
  if (options_.format == AnswerFormat::npy) {
    add_bytes(to, tile);
    add_bytes(to, std::int64_t{cell.cell});
    for (std::size_t k = 0; k < corners; ++k) add_bytes(to, vertex(k));
    if (options_.final) add_bytes(to, std::int64_t{cell.final});
    return;
  }
  begin_line(to, p);
  const bool json = options_.format == AnswerFormat::json;
  if (json && !cell) {
    to += "\"cell\":null";
    end_line(to, cell.final);
    return;
  }
  to += json ? "\"tile\":" : "";
  if (cell) add_whole(to, tile);
  to += json ? ",\"cell\":" : ",";
  if (cell) add_whole(to, cell.cell);
  to += json ? ",\"vertices\":[" : ",";
  for (std::size_t k = 0; k < corners; ++k) {
    if (k > 0) to += ',';
    if (cell) add_whole(to, vertex(k));
  }
  to += json ? "]" : "";
  end_line(to, cell.final);
}

void Answers::end_line(std::string& to, bool final) const {
  const bool json = options_.format == AnswerFormat::json;
  if (options_.final) to += json ? final ? ",\"final\":true" : ",\"final\":false" : final ? ",1" : ",0";
  to += json ? "}\n" : "\n";
}

void Answers::add(std::string& to, const Point& p, const query::Interpolated& answer) const {
  if (options_.format == AnswerFormat::npy) {
    add_bytes(to, answer.value);
    if (options_.final) add_bytes(to, answer.final ? 1.0 : 0.0);
    return;
  }
  begin_line(to, p);
  const bool json = options_.format == AnswerFormat::json;
  to += json ? "\"value\":" : "";
  if (json || !std::isnan(answer.value)) add_number(to, answer.value);
  if (options_.weights) {
    const auto list = [&](std::size_t n, const auto& one) {
      for (std::size_t i = 0; i < n; ++i) {
        if (i > 0) to += json ? ',' : ' ';
        one(i);
      }
    };
    to += json ? ",\"vertices\":[" : ",";
    list(answer.vertices.size(), [&](std::size_t i) { to += to_string(answer.vertices[i]); });
    to += json ? "],\"weights\":[" : ",";
    list(answer.weights.size(), [&](std::size_t i) { add_number(to, answer.weights[i]); });
    to += json ? "]" : "";
  }
  end_line(to, answer.final);
}

void add_number(std::string& to, double number) {
  if (!std::isfinite(number)) {
    to += "null";
    return;
  }
  char digits[32];
  to.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

}  // namespace tessera

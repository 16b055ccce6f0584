#include "src/input/mesh/obj_reader.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "src/base/printable.h"
#include "src/input/bytes/number.h"
#include "src/input/mesh/vertex_text.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

// for a line with its continuations, as for a single line
constexpr std::size_t line_bytes_max = std::size_t{1} << 20;

// Returns what follows "v" in the next line that begins with it. Nothing at the end of the file. If the line is
// continued, `joined` stores it.
Result<std::optional<std::string_view>> next_vertex_line(LineReader& lines, std::string& joined) {
  while (true) {
    BOOST_OUTCOME_TRY(line, lines.next());
    if (!line) return std::optional<std::string_view>();
    if (line->ends_with('\\')) {
      joined.clear();
      while (line && line->ends_with('\\')) {
        joined.append(line->substr(0, line->size() - 1)).append(" ");
        if (joined.size() > line_bytes_max)
          return lines.bad_line("is longer than 1 MiB, together with the lines that it continues");
        BOOST_OUTCOME_TRY(continued, lines.next());
        line = continued;
      }
      if (line) joined.append(*line);
      line = joined;
    }
    const std::size_t at = std::min(line->find_first_not_of(" \t"), line->size());
    const auto text = line->substr(at);
    if (text.size() < 2 || text[0] != 'v' || (text[1] != ' ' && text[1] != '\t')) continue;
    return std::optional(text.substr(1, text.find('#') - 1));
  }
}

class ObjReader : public VertexTextReader {
 public:
  ObjReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema)
      : VertexTextReader(std::move(info), std::move(lines), schema),
        colours_(!this->info().attributes.empty()),
        names_(names_of_values({{"red"}, {"green"}, {"blue"}})) {}

 private:
  Result<bool> next_vertex(std::vector<double>& values) override {
    values.clear();
    BOOST_OUTCOME_TRY(line, next_vertex_line(lines(), joined_));
    if (!line) return false;
    split_line(*line, Delimiter::blanks, SIZE_MAX, words_);
    const std::size_t n = words_.size();
    if (n != 3 && n != 4 && n != 6 && n != 7)
      return lines().bad_line(
          "has " + std::to_string(n) +
          " numbers; a vertex has x, y and z, then a weight or nothing, then a colour of 3 numbers or nothing");
    if (n == 4 || n == 7) {
      const auto weight = parse_number(words_[3]);
      if (!weight) return lines().bad_line("the weight is " + in_quotes(words_[3]) + ", not a number");
      if (*weight != 1) return lines().bad_line("the weight is " + in_quotes(words_[3]) + "; only 1 is read");
      words_.erase(words_.begin() + 3);
    }
    BOOST_OUTCOME_TRYV(add_numbers(words_, std::span(names_).first(words_.size()), lines(), values));
    if (colours_) values.resize(6, std::numeric_limits<double>::quiet_NaN());
    return true;
  }

  bool colours_;
  std::vector<std::string> names_;
  std::vector<std::string_view> words_;
  std::string joined_;
};

}  // namespace

bool looks_like_obj(std::string_view begin) {
  constexpr std::array<std::string_view, 11> others{"mtllib", "usemtl", "o",  "g", "s", "vt",
                                                    "vn",     "vp",     "mg", "f", "l"};
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t end = begin.find('\n');
    if (end == std::string_view::npos) return false;  // the line may be incomplete
    std::string_view line = begin.substr(0, end);
    begin.remove_prefix(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    split_line(line.substr(0, line.find('#')), Delimiter::blanks, 4, words);
    if (words.empty() || std::find(others.begin(), others.end(), words[0]) != others.end()) continue;
    return words[0] == "v" && words.size() == 4 && parse_number(words[1]) && parse_number(words[2]);
  }
}

Result<std::unique_ptr<PointReader>> open_obj(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  BOOST_OUTCOME_TRYV(check_is_text(*source));
  FileInfo info = info_of(*source, "obj");
  LineReader lines(std::move(source));
  std::string joined;
  BOOST_OUTCOME_TRY(first, next_vertex_line(lines, joined));
  if (!first) return error(Errc::bad_input, info.path.string() + ": holds no points: no line begins with 'v'");
  std::vector<std::string_view> words;
  split_line(*first, Delimiter::blanks, SIZE_MAX, words);
  const bool colours = words.size() >= 6;
  info.detail = colours ? "OBJ, text, with colours" : "OBJ, text";
  if (colours)
    for (const char* name : {"red", "green", "blue"}) info.attributes.push_back({name, AttributeType::f64});
  lines.rewind();
  return std::unique_ptr<PointReader>(new ObjReader(std::move(info), std::move(lines), attributes));
}

}  // namespace tessera

#include "src/input/mesh/stl_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/printable.h"
#include "src/input/mesh/vertex_text.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

bool is_keyword(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(),
                    [](unsigned char a, char b) { return std::tolower(a) == b; });
}

class StlTextReader : public VertexTextReader {
 public:
  StlTextReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema)
      : VertexTextReader(std::move(info), std::move(lines), schema) {}

 private:
  // solid NAME { facet normal i j k outer loop { vertex x y z } x 3 endloop endfacet } endsolid NAME
  Result<bool> next_vertex(std::vector<double>& values) override {
    values.clear();
    if (corner_ == 3) {
      BOOST_OUTCOME_TRYV(expect("endloop"));
      BOOST_OUTCOME_TRYV(expect("endfacet"));
      corner_ = 0;
    }
    if (corner_ == 0) {
      BOOST_OUTCOME_TRY(facet, next_facet());
      if (!facet) return false;
    }
    BOOST_OUTCOME_TRYV(expect("vertex"));
    for (const auto& name : names_) {
      BOOST_OUTCOME_TRY(word, next_word());
      if (!word) return ends();
      BOOST_OUTCOME_TRYV(add_numbers(std::span(&*word, 1), std::span(&name, 1), lines(), values));
    }
    ++corner_;
    return true;
  }

  // Moves behind the next "outer loop". Returns false after the last solid.
  Result<bool> next_facet() {
    while (true) {
      BOOST_OUTCOME_TRY(word, next_word());
      if (!word && !in_solid_) return false;
      if (!word) return ends();
      if (!in_solid_) {
        if (!is_keyword(*word, "solid")) return unexpected(*word, "solid");
      } else if (is_keyword(*word, "facet")) {
        BOOST_OUTCOME_TRYV(expect("normal"));
        // The normal is skipped: it follows from the corners, and some programs do not write numbers here.
        for (int axis = 0; axis < 3; ++axis) {
          BOOST_OUTCOME_TRY(component, next_word());
          if (!component) return ends();
        }
        BOOST_OUTCOME_TRYV(expect("outer"));
        BOOST_OUTCOME_TRYV(expect("loop"));
        return true;
      } else if (!is_keyword(*word, "endsolid")) {
        return unexpected(*word, "facet' or 'endsolid");
      }
      in_solid_ = !in_solid_;
      at_ = words_.size();  // the rest of the line is a name
    }
  }

  Status expect(std::string_view keyword) {
    BOOST_OUTCOME_TRY(word, next_word());
    if (!word) return ends();
    if (!is_keyword(*word, keyword)) return unexpected(*word, keyword);
    return success();
  }

  Result<std::optional<std::string_view>> next_word() {
    while (at_ == words_.size()) {
      BOOST_OUTCOME_TRY(line, lines().next());
      words_.clear();
      at_ = 0;
      if (!line) return std::optional<std::string_view>();
      split_line(*line, Delimiter::blanks, SIZE_MAX, words_);
    }
    return std::optional(words_[at_++]);
  }

  Error unexpected(std::string_view word, std::string_view instead) {
    return lines().bad_line(in_quotes(word) + " stands where '" + std::string(instead) + "' is expected");
  }
  Error ends() { return lines().bad_line("the file ends within a solid"); }

  std::array<std::string, 3> names_{"x", "y", "z"};
  bool in_solid_ = false;
  int corner_ = 0;  // the next corner of the current triangle; 3: behind its last corner
  std::vector<std::string_view> words_;
  std::size_t at_ = 0;  // the index of the next word
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_stl_text(std::unique_ptr<ByteSource> source,
                                                   const std::vector<Attribute>& attributes) {
  FileInfo info = info_of(*source, "stl");
  info.detail = "STL, text";
  return std::unique_ptr<PointReader>(new StlTextReader(std::move(info), LineReader(std::move(source)), attributes));
}

}  // namespace tessera

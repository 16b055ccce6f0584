#include "src/input/scans/pts_reader.h"

#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/input/bytes/line_reader.h"
#include "src/input/mesh/vertex_text.h"
#include "src/input/text/text_columns.h"
#include "src/input/text/text_reader.h"

namespace tessera {
namespace {

using Words = std::vector<std::string_view>;

// The number of points, if the words are nothing else.
std::optional<std::uint64_t> count_of(const Words& words) {
  if (words.size() != 1) return std::nullopt;
  std::uint64_t count = 0;
  const auto [end, code] = std::from_chars(words[0].data(), words[0].data() + words[0].size(), count);
  return code == std::errc() && end == words[0].data() + words[0].size() ? std::optional(count) : std::nullopt;
}

std::vector<Attribute> attributes_of(std::size_t words) {
  std::vector<Attribute> attributes;
  if (words == 4 || words == 7) attributes.push_back({"intensity", AttributeType::f64});
  if (words == 6 || words == 7)
    for (const char* name : {"red", "green", "blue"}) attributes.push_back({name, AttributeType::u8});
  return attributes;
}

class PtsReader : public VertexTextReader {
 public:
  PtsReader(FileInfo info, LineReader lines, const std::vector<Attribute>& schema)
      : VertexTextReader(std::move(info), std::move(lines), schema), names_(names_of_values(this->info().attributes)) {}

 private:
  Result<bool> next_vertex(std::vector<double>& values) override {
    while (left_ == 0) {
      BOOST_OUTCOME_TRY(there, next_words(lines(), words_));
      if (!there) return false;
      const auto count = count_of(words_);
      if (!count) return lines().bad_line("the number of points of the next part is expected here");
      left_ = *count;
    }
    BOOST_OUTCOME_TRY(there, next_words(lines(), words_));
    if (!there)
      return lines().bad_line("the file ends " + std::to_string(left_) + " points before the end of the last part");
    if (words_.size() != names_.size())
      return lines().bad_line("a point is a line of " + std::to_string(names_.size()) +
                              " numbers in this file, but this line has " + std::to_string(words_.size()));
    --left_;
    values.clear();
    BOOST_OUTCOME_TRYV(add_numbers(words_, names_, lines(), values));
    return true;
  }

  std::vector<std::string> names_;
  std::uint64_t left_ = 0;
  Words words_;
};

}  // namespace

Result<std::unique_ptr<PointReader>> open_pts(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes, const ReadHints& hints) {
  BOOST_OUTCOME_TRYV(check_is_text(*source));
  FileInfo info = info_of(*source, "pts");
  LineReader lines(std::move(source));
  Words words;
  BOOST_OUTCOME_TRY(there, next_words(lines, words));
  if (!there || !count_of(words)) return open_text(lines.take_source(), attributes, hints);
  BOOST_OUTCOME_TRY(point, next_words(lines, words));
  if (!point) return lines.bad_line("the file ends before the first point");
  if (words.size() != 3 && words.size() != 4 && words.size() != 6 && words.size() != 7)
    return lines.bad_line("a point of a PTS file is a line of 3, 4, 6 or 7 numbers, but this line has " +
                          std::to_string(words.size()));
  lines.rewind();
  info.detail = "PTS, text";
  info.attributes = attributes_of(words.size());
  return std::unique_ptr<PointReader>(new PtsReader(std::move(info), std::move(lines), attributes));
}

}  // namespace tessera

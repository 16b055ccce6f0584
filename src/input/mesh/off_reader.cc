#include "src/input/mesh/off_reader.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>
#include <utility>

#include "src/base/printable.h"
#include "src/input/mesh/vertex_text.h"
#include "src/input/text/text_columns.h"

namespace tessera {
namespace {

// What the letters before OFF say about each vertex.
struct OffKind {
  bool texture = false, colours = false, normals = false;
  bool homogeneous = false;    // 4OFF: x y z w
  bool any_dimension = false;  // nOFF: the number of coordinates comes before the counts
};

std::optional<OffKind> kind_of(std::string_view keyword) {
  OffKind kind;
  const auto take = [&](std::string_view letters) {
    if (!keyword.starts_with(letters)) return false;
    keyword.remove_prefix(letters.size());
    return true;
  };
  kind.texture = take("ST");
  kind.colours = take("C");
  kind.normals = take("N");
  kind.homogeneous = take("4");
  kind.any_dimension = take("n");
  return keyword == "OFF" ? std::optional(kind) : std::nullopt;
}

struct OffHeader {
  std::string keyword;
  OffKind kind;
  std::uint64_t vertices = 0, faces = 0;
};

// Reads the numbers of vertices, faces and edges. The last one is often missing.
Status take_counts(std::span<const std::string_view> words, const LineReader& lines, OffHeader& header) {
  if (words.size() < 2 || words.size() > 3)
    return lines.bad_line("has " + std::to_string(words.size()) +
                          " words where the numbers of vertices, faces and edges are expected");
  for (const auto word : words) {
    std::uint64_t count = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), count);
    if (code != std::errc() || end != word.data() + word.size())
      return lines.bad_line(in_quotes(word) + " is not a number of vertices, faces or edges");
    if (word.data() == words[0].data()) header.vertices = count;
    if (word.data() == words[1].data()) header.faces = count;
  }
  return success();
}

Result<OffHeader> read_header(LineReader& lines) {
  OffHeader header;
  std::vector<std::string_view> words;
  const auto nothing = [&] {
    return error(Errc::bad_input, lines.source().path().string() + ": ends within the OFF header");
  };
  BOOST_OUTCOME_TRY(first, next_words(lines, words, '#'));
  if (!first) return nothing();
  const auto kind = kind_of(words[0]);
  // Geomview's readers accept a file without the keyword. A file called .off that begins with numbers is read in the
  // same way.
  const bool number = !words[0].empty() && std::string_view("0123456789").find(words[0][0]) != std::string_view::npos;
  if (!kind && !number)
    return lines.bad_line("begins with " + in_quotes(words[0]) +
                          ", but an OFF file begins with OFF, COFF, NOFF or STOFF");
  std::span<const std::string_view> counts = words;
  if (kind) {
    header.kind = *kind;
    header.keyword = std::string(words[0]);
    if (kind->any_dimension) return lines.bad_line("nOFF, with points of any dimension, is not read");
    if (kind->homogeneous) return lines.bad_line("4OFF, with homogeneous coordinates, is not read");
    if (words.size() > 1 && words[1] == "BINARY") return lines.bad_line("binary OFF is not read; save it as text");
    counts = counts.subspan(1);
    if (counts.empty()) {
      BOOST_OUTCOME_TRY(second, next_words(lines, words, '#'));
      if (!second) return nothing();
      counts = words;
    }
  }
  BOOST_OUTCOME_TRYV(take_counts(counts, lines, header));
  return header;
}

class OffReader : public VertexTextReader {
 public:
  OffReader(FileInfo info, LineReader lines, const OffHeader& header, const std::vector<Attribute>& schema)
      : VertexTextReader(std::move(info), std::move(lines), schema),
        vertices_(header.vertices),
        faces_(header.faces),
        names_(names_of_values(this->info().attributes)) {}

 private:
  Result<bool> next_vertex(std::vector<double>& values) override {
    values.clear();
    if (position_ == vertices_) {
      BOOST_OUTCOME_TRYV(check_end());
      return false;
    }
    BOOST_OUTCOME_TRY(there, next_words(lines(), words_, '#'));
    if (!there)
      return lines().bad_line("the file ends after " + std::to_string(position_) + " of " + std::to_string(vertices_) +
                              " vertices");
    if (words_.size() != names_.size())
      return lines().bad_line("a vertex is a line of " + std::to_string(names_.size()) +
                              " numbers in this file, but this line has " + std::to_string(words_.size()));
    BOOST_OUTCOME_TRYV(add_numbers(words_, names_, lines(), values));
    ++position_;
    return true;
  }

  // A file that was cut off within the last vertex lacks its faces.
  Status check_end() {
    if (checked_) return success();
    if (faces_ > 0) {
      BOOST_OUTCOME_TRY(there, next_words(lines(), words_, '#'));
      if (!there)
        return lines().bad_line("the file ends before the first of " + std::to_string(faces_) +
                                " faces; the last vertex may be cut off");
    }
    checked_ = true;
    return lines().source().check_unchanged();
  }

  std::uint64_t vertices_, faces_, position_ = 0;
  bool checked_ = false;
  std::vector<std::string> names_;
  std::vector<std::string_view> words_;
};

// The attributes after x y z, in the order of Geomview. Without vertices it is unknown whether colours have alpha.
std::vector<Attribute> attributes_of(const OffKind& kind, std::size_t words) {
  std::vector<Attribute> attributes;
  const auto add = [&](std::initializer_list<const char*> names) {
    for (const auto* name : names) attributes.push_back({name, AttributeType::f64});
  };
  if (kind.normals) add({"nx", "ny", "nz"});
  const std::size_t others = 3 + (kind.normals ? 3u : 0u) + (kind.texture ? 2u : 0u);
  if (kind.colours) add({"red", "green", "blue"});
  if (kind.colours && words != others + 3) add({"alpha"});
  if (kind.texture) add({"s", "t"});
  return attributes;
}

}  // namespace

bool looks_like_off(std::string_view begin) {
  while (true) {
    begin.remove_prefix(std::min(begin.find_first_not_of(" \t\r\n"), begin.size()));
    if (!begin.starts_with('#')) break;
    begin.remove_prefix(std::min(begin.find('\n'), begin.size()));
  }
  return kind_of(begin.substr(0, begin.find_first_of(" \t\r\n#"))).has_value();
}

Result<std::unique_ptr<PointReader>> open_off(std::unique_ptr<ByteSource> source,
                                              const std::vector<Attribute>& attributes) {
  FileInfo info = info_of(*source, "off");
  LineReader lines(std::move(source));
  BOOST_OUTCOME_TRY(header, read_header(lines));
  BOOST_OUTCOME_TRYV(check_is_text(lines.source()));
  // A vertex takes at least six bytes. Refusing here avoids that code reserves memory for 2^60 vertices.
  if (header.vertices > info.content_bytes / 6 + 1)
    return lines.bad_line("promises " + std::to_string(header.vertices) + " vertices, more than the file can hold");
  const std::uint64_t lines_before = lines.number();
  std::vector<std::string_view> words;
  BOOST_OUTCOME_TRY(there, next_words(lines, words, '#'));
  info.detail = header.keyword.empty() ? "OFF without its keyword, text" : header.keyword + ", text";
  info.points = header.vertices;
  info.attributes = attributes_of(header.kind, there ? words.size() : 0);
  lines.rewind();
  while (lines.number() < lines_before) {
    BOOST_OUTCOME_TRYV(lines.next());
  }
  return std::unique_ptr<PointReader>(new OffReader(std::move(info), std::move(lines), header, attributes));
}

}  // namespace tessera

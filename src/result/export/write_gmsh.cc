// Gmsh's MSH 4.1, as text or binary. A tile is an entity and a physical group "tile N" with the tag N + 1. Facets of
// only one cell form the group "boundary", turned outwards. Vertices belong to the tile that owns them, and cells to
// theirs, in the order of MeshHead::ranges. The boundary, the box and the number of elements are known only at the end,
// so their places are filled then. Elements of the boundary also have values of the cells' columns, those of their
// cell, because meshio needs values of every element.
#include <algorithm>
#include <array>
#include <deque>
#include <set>
#include <string>

#include "src/base/attribute_value.h"
#include "src/result/export/boundary.h"
#include "src/result/export/field_name.h"
#include "src/result/export/formats.h"
#include "src/result/export/put_aside.h"

namespace tessera::exports {

namespace {

namespace fs = std::filesystem;

// A line of numbers, as text or in the format's binary types. Wide numbers take the same room whatever their value.
class Line {
 public:
  Line(Stream& stream, bool binary) : stream_(stream), binary_(binary) {}
  ~Line() {
    if (!binary_) stream_.text("\n");
  }
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  Line& tag(std::int32_t value) { return put(value); }
  Line& count(std::uint64_t value) { return put(value); }
  Line& real(double value) { return put(value); }
  Line& wide(std::uint64_t value) { return put_wide(value); }
  Line& wide(double value) { return put_wide(value); }

 private:
  template <class Value>
  Line& put(Value value) {
    if (binary_) {
      stream_.value(value);
    } else {
      separate();
      stream_.digits(value);
    }
    return *this;
  }
  template <class Value>
  Line& put_wide(Value value) {
    if (binary_) return put(value);
    constexpr std::uint64_t width = 25;
    const std::uint64_t start = stream_.offset();
    put(value);
    stream_.text(std::string_view("                         ").substr(0, width - (stream_.offset() - start)));
    return *this;
  }
  void separate() {
    if (!first_) stream_.text(" ");
    first_ = false;
  }
  Stream& stream_;
  bool binary_;
  bool first_ = true;
};

class GmshWriter : public MeshWriter {
 public:
  static OpenedWriter open(const fs::path& path, const MeshHead& head, bool binary) {
    BOOST_OUTCOME_TRY(file, OutputFile::create(path));
    auto writer = std::unique_ptr<GmshWriter>(new GmshWriter(std::move(file), head, binary));
    for (std::size_t i = 0; i <= head.columns.size() + head.cell_columns.size(); ++i) {
      BOOST_OUTCOME_TRY(numbers, PutAside::create(path));
      writer->aside_.push_back(std::move(numbers));
    }
    return std::unique_ptr<MeshWriter>(std::move(writer));
  }

  void vertex(const VertexView& vertex) override {
    if (left_in_range_ == 0) begin_vertices();
    --left_in_range_;
    box_.add(vertex.at);
    Line(stream_, binary_).real(vertex.at.x).real(vertex.at.y).real(vertex.at.z);
    for (std::size_t i = 0; i < head_.columns.size(); ++i)
      aside_[i].add(as_double(head_.columns[i].type, vertex.row + head_.columns[i].offset));
  }
  void cell(const CellView& cell) override {
    if (cells_ == 0) begin_cells();
    if (left_in_range_ == 0) begin_range(&TileRange::cells, head_.dimension == 2 ? 2 : 4);
    --left_in_range_;
    Line line(stream_, binary_);
    line.count(++cells_);
    for (std::size_t k = 0; k < head_.corners(); ++k) line.count(cell.numbers[k] + 1);
    longest_edges().add(cell.longest_edge);
    for (std::size_t c = 0; c < head_.cell_columns.size(); ++c)
      cell_column(c).add(as_double(head_.cell_columns[c].type, cell.values[c]));
    if (status_) status_ = boundary_.add(cell, cells_ - 1);
  }
  Status check() override {
    BOOST_OUTCOME_TRYV(stream_.status());
    for (const auto& numbers : aside_) {
      BOOST_OUTCOME_TRYV(numbers.status());
    }
    return status_;
  }

  Result<std::uint64_t> finish() override {
    BOOST_OUTCOME_TRYV(check());
    if (cells_ == 0) begin_cells();
    const std::uint64_t boundary_head = stream_.offset();
    std::uint64_t facets = 0;
    if (head_.cells > 0) begin_boundary(stream_, facets);
    for (std::size_t c = 0; c < head_.cell_columns.size(); ++c) {
      BOOST_OUTCOME_TRYV(cell_column(c).flush());
    }
    BOOST_OUTCOME_TRYV(
        boundary_.for_each([&](std::span<const std::uint32_t> vertices, double longest_edge, std::uint64_t cell) {
          Line line(stream_, binary_);
          line.count(cells_ + ++facets);
          for (const auto number : vertices) line.count(number + std::uint64_t{1});
          longest_edges().add(longest_edge);
          for (std::size_t c = 0; c < head_.cell_columns.size(); ++c) repeat(cell_column(c), cell);
        }));
    BOOST_OUTCOME_TRYV(status_);
    end_section("Elements");
    for (std::size_t i = 0; i < head_.columns.size(); ++i) {
      BOOST_OUTCOME_TRYV(data("NodeData", head_.columns[i].name, head_.vertices, aside_[i]));
    }
    BOOST_OUTCOME_TRYV(data("ElementData", "longest_edge", cells_ + facets, longest_edges()));
    std::set<std::string> taken{"longest_edge"};
    for (std::size_t c = 0; c < head_.cell_columns.size(); ++c) {
      const std::string name = field_name(head_.cell_columns[c].name, taken);
      BOOST_OUTCOME_TRYV(data("ElementData", name, cells_ + facets, cell_column(c)));
    }
    BOOST_OUTCOME_TRYV(stream_.flush());

    BOOST_OUTCOME_TRYV(fill(entities_, [&](Stream& to) { entities(to); }));
    BOOST_OUTCOME_TRYV(fill(elements_, [&](Stream& to) { elements_head(to, cells_ + facets); }));
    if (head_.cells > 0) {
      BOOST_OUTCOME_TRYV(fill(boundary_head, [&](Stream& to) { begin_boundary(to, facets); }));
    }
    return file_.finish();
  }

 private:
  GmshWriter(OutputFile file, const MeshHead& head, bool binary)
      : file_(std::move(file)),
        stream_(file_, 0),
        head_(head),
        binary_(binary),
        boundary_(head.dimension, folder_of(file_.target())) {
    stream_.text(binary_ ? "$MeshFormat\n4.1 1 8\n" : "$MeshFormat\n4.1 0 8\n");
    if (binary_) stream_.value(std::int32_t{1});  // shows the byte order
    if (binary_) stream_.text("\n");
    stream_.text("$EndMeshFormat\n$PhysicalNames\n" + std::to_string(head_.ranges.size() + (head_.cells > 0 ? 1 : 0)) +
                 "\n");
    if (head_.cells > 0) stream_.text(std::to_string(head_.dimension - 1) + " 1 \"boundary\"\n");
    for (const auto& range : head_.ranges)
      stream_.text(std::to_string(head_.dimension) + " " + std::to_string(tag_of(range)) + " \"tile " +
                   std::to_string(range.tile.value) + "\"\n");
    stream_.text("$EndPhysicalNames\n$Entities\n");
    entities_ = stream_.offset();
    entities(stream_);
    end_section("Entities");
    stream_.text("$Nodes\n");
    const auto blocks =
        std::count_if(head_.ranges.begin(), head_.ranges.end(), [](auto& range) { return range.vertices > 0; });
    Line(stream_, binary_)
        .count(static_cast<std::uint64_t>(blocks))
        .count(head_.vertices)
        .count(std::min<std::uint64_t>(1, head_.vertices))
        .count(head_.vertices);
  }

  PutAside& longest_edges() { return aside_[head_.columns.size()]; }
  PutAside& cell_column(std::size_t c) { return aside_[head_.columns.size() + 1 + c]; }
  // Writes the value of a facet's cell for the facet.
  void repeat(PutAside& numbers, std::uint64_t cell) {
    if (!status_) return;
    if (const auto number = numbers.at(cell)) {
      numbers.add(number.value());
    } else {
      status_ = number.error();
    }
  }

  static std::int32_t tag_of(const TileRange& range) { return static_cast<std::int32_t>(range.tile.value) + 1; }
  void end_section(const char* name) { stream_.text(std::string(binary_ ? "\n" : "") + "$End" + name + "\n"); }

  // All entities get the box of the whole mesh: Gmsh only requires that nothing lies outside.
  void entities(Stream& to) const {
    std::array<std::uint64_t, 4> counts{};  // by dimension
    counts[static_cast<std::size_t>(head_.dimension)] = head_.ranges.size();
    counts[static_cast<std::size_t>(head_.dimension) - 1] = head_.cells > 0 ? 1 : 0;
    Line(to, binary_).count(counts[0]).count(counts[1]).count(counts[2]).count(counts[3]);
    const Bounds box = box_.empty() ? Bounds{.lo = {}, .hi = {}} : box_;
    const auto entity = [&](std::int32_t tag) {
      Line line(to, binary_);
      line.tag(tag);
      for (const Point& corner : {box.lo, box.hi}) line.wide(corner.x).wide(corner.y).wide(corner.z);
      line.count(1).tag(tag).count(0);  // one physical group with the same tag; no bounding entities
    };
    if (head_.cells > 0) entity(1);
    for (const auto& range : head_.ranges) entity(tag_of(range));
  }

  // Begins the block of the next range that has elements.
  void begin_range(std::uint64_t TileRange::*count, std::int32_t third) {
    while (head_.ranges[range_].*count == 0) ++range_;
    const TileRange& range = head_.ranges[range_++];
    left_in_range_ = range.*count;
    Line(stream_, binary_).tag(head_.dimension).tag(tag_of(range)).tag(third).count(left_in_range_);
  }
  void begin_vertices() {
    begin_range(&TileRange::vertices, 0);  // not parametric
    for (std::uint64_t i = 0; i < left_in_range_; ++i) Line(stream_, binary_).count(++numbered_);
  }
  void begin_cells() {
    end_section("Nodes");
    stream_.text("$Elements\n");
    range_ = 0;
    elements_ = stream_.offset();
    elements_head(stream_, 0);
  }
  void elements_head(Stream& to, std::uint64_t elements) const {
    const auto blocks =
        std::count_if(head_.ranges.begin(), head_.ranges.end(), [](auto& range) { return range.cells > 0; });
    Line(to, binary_)
        .count(static_cast<std::uint64_t>(blocks) + (head_.cells > 0 ? 1 : 0))
        .wide(elements)
        .count(std::min<std::uint64_t>(1, head_.cells))
        .wide(elements);
  }
  void begin_boundary(Stream& to, std::uint64_t facets) const {
    Line(to, binary_).tag(head_.dimension - 1).tag(1).tag(head_.dimension == 2 ? 1 : 2).wide(facets);
  }

  Status data(const char* section, std::string name, std::uint64_t rows, PutAside& numbers) {
    if (rows == 0) return success();
    // The name ends at the next quotation mark, and its line at a line break.
    for (char& c : name)
      if (c == '"' || static_cast<unsigned char>(c) < ' ') c = c == '"' ? '\'' : ' ';
    stream_.text(std::string("$") + section + "\n1\n\"" + name + "\"\n1\n0\n3\n0\n1\n" + std::to_string(rows) + "\n");
    std::int32_t number = 0;
    BOOST_OUTCOME_TRYV(numbers.for_each([&](double value) { Line(stream_, binary_).tag(++number).real(value); }));
    end_section(section);
    return success();
  }

  template <class Write>
  Status fill(std::uint64_t offset, Write write) {
    Stream to(file_, offset);
    write(to);
    return to.flush();
  }

  OutputFile file_;
  Stream stream_;
  MeshHead head_;
  bool binary_;
  Boundary boundary_;
  std::deque<PutAside> aside_;  // attributes of vertices, the longest edges, columns of cells
  Bounds box_;
  std::size_t range_ = 0;            // the next range
  std::uint64_t left_in_range_ = 0;  // vertices, then cells
  std::uint64_t numbered_ = 0, cells_ = 0;
  std::uint64_t entities_ = 0, elements_ = 0;  // offsets in the file
  Status status_ = success();
};

}  // namespace

OpenedWriter open_gmsh(const fs::path& path, const MeshHead& head) { return GmshWriter::open(path, head, false); }
OpenedWriter open_gmsh_binary(const fs::path& path, const MeshHead& head) { return GmshWriter::open(path, head, true); }

}  // namespace tessera::exports

// PLY, binary little endian: points as doubles, attributes, ids; faces in 2D, an element "cell" of 4 vertices in 3D.
#include <set>
#include <span>

#include "src/base/attribute_value.h"
#include "src/result/export/formats.h"
#include "src/result/export/stream_writer.h"

namespace tessera::exports {

namespace {

const char* ply_type(AttributeType type) {
  switch (type) {
    case AttributeType::u8:
      return "uchar";
    case AttributeType::i8:
      return "char";
    case AttributeType::u16:
      return "ushort";
    case AttributeType::i16:
      return "short";
    case AttributeType::u32:
      return "uint";
    case AttributeType::i32:
      return "int";
    case AttributeType::f32:
      return "float";
    case AttributeType::u64:  // PLY has no 64-bit integers; a double is exact up to 2^53
    case AttributeType::i64:
    case AttributeType::f64:
      return "double";
  }
  return "";
}

// Names end at white space, and must differ from each other.
std::string ply_name(std::string name, std::set<std::string>& taken) {
  for (char& c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte <= ' ' || byte == 0x7f) c = '_';
  }
  while (!taken.insert(name).second) name += '_';
  return name;
}

class PlyWriter : public StreamWriter {
 public:
  PlyWriter(OutputFile file, const MeshHead& head)
      : StreamWriter(std::move(file)),
        columns_(head.columns),
        cell_columns_(head.cell_columns),
        corners_(head.corners()),
        small_ids_(head.ids <= std::uint64_t{1} << 32) {
    std::set<std::string> taken;
    stream_.text("ply\nformat binary_little_endian 1.0\ncomment tessera " + ply_name(head.software_version, taken) +
                 (head.stamp ? "\ncomment " + comment_of(*head.stamp) : "") +
                 (head.corner ? "\ncomment " + head.corner_comment() : "") +
                 (head.comment.empty() ? "" : "\ncomment " + head.comment) + "\nelement vertex " +
                 std::to_string(head.vertices) +
                 "\nproperty double x\nproperty double y\nproperty double z\nproperty " +
                 (small_ids_ ? "uint" : "double") + " id\n");
    taken = {"x", "y", "z", "id"};
    for (const auto& column : columns_)
      stream_.text(std::string("property ") + ply_type(column.type) + " " + ply_name(column.name, taken) + "\n");
    stream_.text(std::string("element ") + (head.dimension == 2 ? "face " : "cell ") + std::to_string(head.cells) +
                 "\nproperty list uchar uint vertex_indices\n");
    taken = {"vertex_indices"};
    for (const auto& column : cell_columns_)
      stream_.text(std::string("property ") + ply_type(column.type) + " " + ply_name(column.name, taken) + "\n");
    stream_.text("end_header\n");
  }

  void vertex(const VertexView& vertex) override {
    stream_.value(vertex.at);
    if (small_ids_) {
      stream_.value(static_cast<std::uint32_t>(vertex.id.value));
    } else {
      stream_.value(static_cast<double>(vertex.id.value));
    }
    for (const auto& column : columns_) put(column.type, vertex.row + column.offset);
  }
  void cell(const CellView& cell) override {
    stream_.value(static_cast<std::uint8_t>(corners_));
    for (std::size_t k = 0; k < corners_; ++k) stream_.value(static_cast<std::uint32_t>(cell.numbers[k]));
    for (std::size_t c = 0; c < cell_columns_.size(); ++c) put(cell_columns_[c].type, cell.values[c]);
  }

 private:
  void put(AttributeType type, const std::byte* from) {
    if (type == AttributeType::u64 || type == AttributeType::i64) {
      stream_.value(as_double(type, from));
    } else {
      stream_.bytes({from, size_of(type)});
    }
  }
  std::vector<Column> columns_;
  std::vector<Attribute> cell_columns_;
  std::size_t corners_;
  bool small_ids_;
};

}  // namespace

OpenedWriter open_ply(const std::filesystem::path& path, const MeshHead& head) {
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<PlyWriter>(std::move(file), head);
}

}  // namespace tessera::exports

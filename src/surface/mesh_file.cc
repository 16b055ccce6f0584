#include "src/surface/mesh_file.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "src/input/bytes/byte_source.h"
#include "src/input/ply/ply_header.h"

namespace tessera::surface {

namespace {

constexpr std::uint64_t block_bytes = std::uint64_t{1} << 20;
constexpr double id_max = 9007199254740992.0;  // 2^53: a double counts exactly up to it

template <class T>
T value_at(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

const PlyElement* find(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

// Returns the offset of a property in an element that has no list before it. Nothing when the property is missing, or
// has another type.
std::optional<std::size_t> offset_of(const PlyElement& element, std::string_view name, AttributeType type) {
  std::size_t offset = 0;
  for (const PlyProperty& property : element.properties) {
    if (property.count) return std::nullopt;
    if (property.name == name) return property.type == type ? std::optional(offset) : std::nullopt;
    offset += size_of(property.type);
  }
  return std::nullopt;
}

// Returns the bytes of an element that begins with triangles: a list with a count of one byte and three numbers.
std::optional<std::size_t> triangle_bytes(const PlyElement& face) {
  if (face.properties.empty()) return std::nullopt;
  const PlyProperty& list = face.properties.front();
  const bool numbers = list.type == AttributeType::u32 || list.type == AttributeType::i32;
  if (list.count != AttributeType::u8 || !numbers) return std::nullopt;
  std::size_t bytes = 1 + 3 * sizeof(std::uint32_t);
  for (std::size_t i = 1; i < face.properties.size(); ++i) {
    if (face.properties[i].count) return std::nullopt;
    bytes += size_of(face.properties[i].type);
  }
  return bytes;
}

}  // namespace

MeshFile::MeshFile(MeshFile&&) noexcept = default;
MeshFile& MeshFile::operator=(MeshFile&&) noexcept = default;
MeshFile::~MeshFile() = default;

Result<MeshFile> MeshFile::open(const std::filesystem::path& path) {
  MeshFile file;
  file.path_ = path;
  BOOST_OUTCOME_TRY(source, open_file(path));
  file.source_ = std::move(source);
  BOOST_OUTCOME_TRYV(file.read_head());
  BOOST_OUTCOME_TRYV(file.read_ids());
  return file;
}

Status MeshFile::read_head() {
  BOOST_OUTCOME_TRY(header, read_ply_header(*source_));
  const PlyElement *vertex = find(header, "vertex"), *face = find(header, "face");
  const auto wanted = [&](const char* what) {
    return bad(std::string("is not a surface that can be checked: it has no ") + what);
  };
  if (header.format != PlyFormat::binary_little_endian || header.elements.size() != 2 || face != &header.elements[1])
    return wanted("vertices and then faces in binary, little endian");
  const auto x = offset_of(*vertex, "x", AttributeType::f64), y = offset_of(*vertex, "y", AttributeType::f64),
             z = offset_of(*vertex, "z", AttributeType::f64);
  if (!x || !y || !z || *y != *x + 8 || *z != *x + 16 || !vertex->fixed_bytes()) return wanted("x, y and z as doubles");
  const auto small = offset_of(*vertex, "id", AttributeType::u32), large = offset_of(*vertex, "id", AttributeType::f64);
  if (!small && !large) return wanted("id of its vertices");
  const auto triangle = triangle_bytes(*face);
  if (!triangle) return wanted("list of three vertices for each face");
  small_ids_ = small.has_value();
  id_at_ = small_ids_ ? *small : *large;
  x_at_ = *x;
  vertex_bytes_ = *vertex->fixed_bytes();
  triangle_bytes_ = *triangle;
  vertices_ = vertex->count;
  triangles_ = face->count;
  vertices_at_ = header.body_at;
  const std::uint64_t body = source_->size() - vertices_at_;
  if (vertices_ > body / vertex_bytes_) return bad("is too short for the vertices that its head announces");
  triangles_at_ = vertices_at_ + vertices_ * vertex_bytes_;
  if (triangles_ != (source_->size() - triangles_at_) / triangle_bytes_ ||
      (source_->size() - triangles_at_) % triangle_bytes_ != 0)
    return bad("has another length than its head says");

  std::vector<std::byte> head(header.body_at);
  BOOST_OUTCOME_TRYV(source_->read(0, head));
  std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    constexpr std::string_view comment = "comment ";
    if (text.starts_with(comment)) {
      auto recipe = read_recipe(text.substr(comment.size(), end - comment.size()));
      if (!recipe) return bad(recipe.error().where);
      if (recipe.value()) recipe_ = std::move(recipe).value();
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return success();
}

Status MeshFile::for_each_record(
    std::uint64_t at, std::uint64_t count, std::size_t bytes,
    const std::function<Status(const std::byte* record, std::uint64_t number)>& visit) const {
  const std::uint64_t most = std::max<std::uint64_t>(1, block_bytes / bytes);
  std::vector<std::byte> block;
  for (std::uint64_t done = 0; done < count;) {
    const std::uint64_t some = std::min(most, count - done);
    block.resize(some * bytes);
    BOOST_OUTCOME_TRYV(source_->read(at + done * bytes, block));
    for (std::uint64_t i = 0; i < some; ++i) {
      BOOST_OUTCOME_TRYV(visit(block.data() + i * bytes, done + i));
    }
    done += some;
  }
  return source_->check_unchanged();
}

Status MeshFile::read_ids() {
  ids_.reserve(vertices_);
  return for_each_record(vertices_at_, vertices_, vertex_bytes_, [&](const std::byte* record, auto number) -> Status {
    std::uint64_t id = value_at<std::uint32_t>(record + id_at_);
    if (!small_ids_) {
      const auto real = value_at<double>(record + id_at_);
      if (!(real >= 0 && real < id_max)) return bad("vertex " + std::to_string(number) + " has no id");
      id = static_cast<std::uint64_t>(real);
    }
    ids_.push_back({id});
    return success();
  });
}

Status MeshFile::for_each_vertex(const std::function<Status(PointId, const Point&)>& visit) const {
  return for_each_record(vertices_at_, vertices_, vertex_bytes_, [&](const std::byte* record, auto number) {
    return visit(ids_[number], value_at<Point>(record + x_at_));
  });
}

Status MeshFile::for_each_triangle(const std::function<Status(const std::array<PointId, 3>&)>& visit) const {
  return for_each_record(triangles_at_, triangles_, triangle_bytes_,
                         [&](const std::byte* record, auto number) -> Status {
                           if (std::to_integer<unsigned>(record[0]) != 3)
                             return bad("face " + std::to_string(number) + " is not a triangle");
                           std::array<PointId, 3> corners;
                           for (std::size_t k = 0; k < 3; ++k) {
                             const auto corner = value_at<std::uint32_t>(record + 1 + 4 * k);
                             if (corner >= ids_.size())
                               return bad("triangle " + std::to_string(number) + " has a vertex " +
                                          std::to_string(corner) + ", which the file does not have");
                             corners[k] = ids_[corner];
                           }
                           if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
                             return bad("triangle " + std::to_string(number) + " has a vertex twice");
                           return visit(corners);
                         });
}

}  // namespace tessera::surface

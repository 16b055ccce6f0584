// Binary glTF 2.0: one mesh of triangles, as browsers, Blender and game engines open it. Positions are 32-bit floats,
// relative to a point near the first vertex, which the node has as doubles. In glTF y points up: x, z, -y.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "src/base/attribute_value.h"
#include "src/base/json/json_text.h"
#include "src/result/export/formats.h"
#include "src/result/export/output.h"

namespace tessera::exports {

namespace {

using Json = nlohmann::ordered_json;
using Floats = std::array<float, 3>;
using Color = std::array<std::uint16_t, 4>;

constexpr int unsigned_short = 5123, unsigned_int = 5125, real = 5126;  // glTF's numbers, which are OpenGL's
constexpr int array_buffer = 34962, element_array_buffer = 34963;
// The JSON comes before the data that it describes, but is known last.
constexpr std::uint64_t description_bytes = 2048;
constexpr std::uint64_t data_at = 12 + 8 + description_bytes + 8;

// The place of red, green or blue in a vertex's row.
struct Channel {
  AttributeType type = AttributeType::u16;
  std::size_t offset = 0;
  std::uint16_t of(const std::byte* row) const {
    const double value = as_double(type, row + offset);
    const double most = type == AttributeType::u8 ? 255 : 65535;
    return static_cast<std::uint16_t>(std::lround(std::clamp(value / most, 0.0, 1.0) * 65535));
  }
};

std::optional<std::array<Channel, 3>> colors_of(const MeshHead& head) {
  std::array<Channel, 3> channels;
  const std::array<const char*, 3> names{"red", "green", "blue"};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto found = std::ranges::find(head.columns, names[k], &Column::name);
    if (found == head.columns.end() || (found->type != AttributeType::u8 && found->type != AttributeType::u16))
      return std::nullopt;
    channels[k] = {found->type, found->offset};
  }
  return channels;
}

class GlbWriter : public MeshWriter {
 public:
  GlbWriter(OutputFile file, const MeshHead& head)
      : file_(std::move(file)),
        channels_(colors_of(head)),
        vertices_(head.vertices),
        cells_(head.cells),
        positions_(file_, data_at),
        colors_(file_, data_at + positions_bytes()),
        corners_(file_, data_at + positions_bytes() + colors_bytes()) {}

  void vertex(const VertexView& vertex) override {
    if (!origin_) origin_ = {std::floor(vertex.at.x), std::floor(vertex.at.y), std::floor(vertex.at.z)};
    const Floats at{static_cast<float>(vertex.at.x - origin_->x), static_cast<float>(vertex.at.z - origin_->z),
                    static_cast<float>(origin_->y - vertex.at.y)};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo_[axis] = std::min(lo_[axis], at[axis]);
      hi_[axis] = std::max(hi_[axis], at[axis]);
    }
    positions_.value(at);
    if (!channels_) return;
    Color color{0, 0, 0, 65535};
    for (std::size_t k = 0; k < 3; ++k) color[k] = (*channels_)[k].of(vertex.row);
    colors_.value(color);
  }
  void cell(const CellView& cell) override {
    for (std::size_t k = 0; k < 3; ++k) corners_.value(static_cast<std::uint32_t>(cell.numbers[k]));
  }
  Status check() override {
    for (const Stream* stream : {&positions_, &colors_, &corners_}) {
      if (!stream->status()) return stream->status();
    }
    return success();
  }
  Result<std::uint64_t> finish() override {
    for (Stream* stream : {&positions_, &colors_, &corners_}) {
      BOOST_OUTCOME_TRYV(stream->flush());
    }
    std::string text = json_text(description());
    text.resize(description_bytes, ' ');
    Stream head(file_, 0);
    head.text("glTF");
    const std::uint64_t data = positions_bytes() + colors_bytes() + corners_bytes();
    for (const std::uint64_t word : {std::uint64_t{2}, data_at + data, description_bytes})
      head.value(static_cast<std::uint32_t>(word));
    head.text("JSON");
    head.text(text);
    head.value(static_cast<std::uint32_t>(data));
    head.text(std::string_view("BIN\0", 4));
    BOOST_OUTCOME_TRYV(head.flush());
    return file_.finish();
  }

 private:
  std::uint64_t positions_bytes() const { return vertices_ * sizeof(Floats); }
  std::uint64_t colors_bytes() const { return channels_ ? vertices_ * sizeof(Color) : 0; }
  std::uint64_t corners_bytes() const { return cells_ * 3 * sizeof(std::uint32_t); }

  Json description() const {
    Json views = Json::array(), accessors = Json::array(), attributes = Json::object();
    std::uint64_t offset = 0;
    const auto add = [&](std::uint64_t bytes, int target, Json accessor) {
      accessor["bufferView"] = views.size();
      views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", target}});
      accessors.push_back(std::move(accessor));
      offset += bytes;
      return accessors.size() - 1;
    };
    attributes["POSITION"] =
        add(positions_bytes(), array_buffer,
            {{"componentType", real}, {"type", "VEC3"}, {"count", vertices_}, {"min", lo_}, {"max", hi_}});
    if (channels_)
      attributes["COLOR_0"] =
          add(colors_bytes(), array_buffer,
              {{"componentType", unsigned_short}, {"type", "VEC4"}, {"count", vertices_}, {"normalized", true}});
    const auto corners = add(corners_bytes(), element_array_buffer,
                             {{"componentType", unsigned_int}, {"type", "SCALAR"}, {"count", 3 * cells_}});
    const Point origin = origin_.value_or(Point{});
    return {{"asset", {{"version", "2.0"}, {"generator", "tessera"}}},
            {"scene", 0},
            {"scenes", Json::array({{{"nodes", {0}}}})},
            {"nodes", Json::array({{{"mesh", 0}, {"translation", {origin.x, origin.z, -origin.y}}}})},
            {"meshes",
             Json::array({{{"primitives",
                            Json::array({{{"attributes", attributes}, {"indices", corners}, {"material", 0}}})}}})},
            {"materials", Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}},
                                        {"doubleSided", true}}})},
            {"accessors", accessors},
            {"bufferViews", views},
            {"buffers", Json::array({{{"byteLength", offset}}})}};
  }

  OutputFile file_;
  std::optional<std::array<Channel, 3>> channels_;
  std::uint64_t vertices_, cells_;
  Stream positions_, colors_, corners_;
  std::optional<Point> origin_;
  Floats lo_{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
  Floats hi_{std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
             std::numeric_limits<float>::lowest()};
};

}  // namespace

OpenedWriter open_glb(const std::filesystem::path& path, const MeshHead& head) {
  const std::uint64_t bytes = data_at + head.vertices * (sizeof(Floats) + sizeof(Color)) + head.cells * 12;
  if (bytes > std::numeric_limits<std::uint32_t>::max())
    return error(Errc::usage,
                 path.string() + ": would be larger than 4 GiB, the most that glTF allows; ply has no such limit");
  BOOST_OUTCOME_TRY(file, OutputFile::create(path));
  return std::make_unique<GlbWriter>(std::move(file), head);
}

}  // namespace tessera::exports

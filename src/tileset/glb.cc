#include "src/tileset/glb.h"

#include <meshoptimizer.h>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace tessera::tileset {
namespace {

using Json = nlohmann::ordered_json;

constexpr int unsigned_byte = 5121, unsigned_short = 5123, unsigned_int = 5125, real = 5126;  // of glTF, OpenGL's
constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr double steps = 65535;
constexpr std::size_t short_indices_max = 65535;  // vertices; index 65535 would restart a primitive

// Strides of vertices are multiples of 4 in glTF, and in what is compressed.
struct PackedPosition {
  std::uint16_t at[3], unused = 0;
};
struct PackedShort {
  std::uint16_t value, unused = 0;
};
struct PackedByte {
  std::uint8_t value, unused[3] = {0, 0, 0};
};

// What one file consists of, as it grows.
class Glb {
 public:
  template <class T>
  void add_vertices(const char* name, const std::vector<T>& values, Json accessor) {
    meshopt_encodeVertexVersion(0);
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), values.data(), values.size(), sizeof(T)));
    attributes_[name] = accessors_.size();
    add(packed, values.size(), sizeof(T), "ATTRIBUTES", array_buffer, true, std::move(accessor));
  }
  void add_indices(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
    meshopt_encodeIndexVersion(1);  // which EXT_meshopt_compression asks for
    std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
    packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(), indices.size()));
    const bool is_short = vertices <= short_indices_max;
    add(packed, indices.size(), is_short ? 2 : 4, "TRIANGLES", element_array_buffer, false,
        {{"componentType", is_short ? unsigned_short : unsigned_int}, {"type", "SCALAR"}});
  }

  std::vector<std::byte> finish(const Json& node) {
    const Json extensions = Json::array({"KHR_mesh_quantization", "EXT_meshopt_compression"});
    Json primitive{{"attributes", attributes_}, {"indices", accessors_.size() - 1}, {"material", 0}};
    Json document{
        {"asset", {{"version", "2.0"}, {"generator", "tessera"}}},
        {"extensionsUsed", extensions},
        {"extensionsRequired", extensions},
        {"scene", 0},
        {"scenes", Json::array({Json{{"nodes", Json::array({0})}}})},
        {"nodes", Json::array({node})},
        {"meshes", Json::array({Json{{"primitives", Json::array({primitive})}}})},
        {"materials",
         {{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}, {"doubleSided", true}}}},
        {"accessors", accessors_},
        {"bufferViews", views_},
        {"buffers",
         {{{"byteLength", bytes_.size()}},
          // Where readers unpack to.
          {{"byteLength", unpacked_}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}}}};
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> file;
    const auto word = [&](std::size_t value) {
      const auto small = static_cast<std::uint32_t>(value);
      const auto* raw = reinterpret_cast<const std::byte*>(&small);
      file.insert(file.end(), raw, raw + sizeof small);
    };
    file.reserve(28 + text.size() + bytes_.size());
    word(0x46546C67);  // "glTF"
    word(2);
    word(28 + text.size() + bytes_.size());
    word(text.size());
    word(0x4E4F534A);  // "JSON"
    const auto* raw = reinterpret_cast<const std::byte*>(text.data());
    file.insert(file.end(), raw, raw + text.size());
    word(bytes_.size());
    word(0x004E4942);  // "BIN"
    file.insert(file.end(), bytes_.begin(), bytes_.end());
    return file;
  }

 private:
  void add(const std::vector<unsigned char>& packed, std::size_t count, std::size_t stride, const char* mode,
           int target, bool has_stride, Json accessor) {
    Json view{{"buffer", 1}, {"byteOffset", unpacked_}, {"byteLength", count * stride}};
    if (has_stride) view["byteStride"] = stride;
    view["target"] = target;
    view["extensions"] = {{"EXT_meshopt_compression",
                           {{"buffer", 0},
                            {"byteOffset", bytes_.size()},
                            {"byteLength", packed.size()},
                            {"byteStride", stride},
                            {"mode", mode},
                            {"count", count}}}};
    accessor["bufferView"] = views_.size();
    accessor["count"] = count;
    views_.push_back(std::move(view));
    accessors_.push_back(std::move(accessor));
    const auto* raw = reinterpret_cast<const std::byte*>(packed.data());
    bytes_.insert(bytes_.end(), raw, raw + packed.size());
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    unpacked_ += (count * stride + 3) / 4 * 4;
  }

  Json attributes_ = Json::object(), accessors_ = Json::array(), views_ = Json::array();
  std::vector<std::byte> bytes_;
  std::size_t unpacked_ = 0;
};

// In the order in which triangles need them, which is what packs well.
Surface in_reading_order(const Surface& surface) {
  Surface ordered{{}, std::vector<std::uint32_t>(surface.corners.size())};
  const std::size_t n = surface.vertices.size();
  meshopt_optimizeVertexCache(ordered.corners.data(), surface.corners.data(), surface.corners.size(), n);
  std::vector<std::uint32_t> to(n);
  meshopt_optimizeVertexFetchRemap(to.data(), ordered.corners.data(), ordered.corners.size(), n);
  ordered.vertices.resize(n);
  for (std::size_t i = 0; i < n; ++i) ordered.vertices[to[i]] = surface.vertices[i];
  for (std::uint32_t& corner : ordered.corners) corner = to[corner];
  return ordered;
}

}  // namespace

std::vector<std::byte> to_glb(const Surface& surface, const Point& origin) {
  const Surface ordered = in_reading_order(surface);
  const Bounds bounds = ordered.bounds();
  double step[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double length = bounds.hi[axis] - bounds.lo[axis];
    step[axis] = length > 0 ? length / steps : 1;
  }
  std::vector<PackedPosition> positions;
  std::vector<PackedShort> intensities;
  std::vector<PackedByte> classes;
  std::vector<float> tiles;
  std::uint16_t lo[3] = {65535, 65535, 65535}, hi[3] = {0, 0, 0};
  for (const SurfaceVertex& v : ordered.vertices) {
    std::uint16_t q[3];
    for (int axis = 0; axis < 3; ++axis)
      q[axis] = static_cast<std::uint16_t>(std::lround((v.at[axis] - bounds.lo[axis]) / step[axis]));
    // -y grows where y falls: counted from the other end.
    const auto top = static_cast<std::uint16_t>(std::lround((bounds.hi.y - bounds.lo.y) / step[1]));
    PackedPosition& packed = positions.emplace_back();
    packed.at[0] = q[0];
    packed.at[1] = q[2];
    packed.at[2] = static_cast<std::uint16_t>(top - q[1]);
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], packed.at[k]);
      hi[k] = std::max(hi[k], packed.at[k]);
    }
    intensities.push_back({v.intensity});
    classes.push_back({v.classification});
    tiles.push_back(static_cast<float>(v.tile.value));  // whole numbers below 2^24
  }
  Glb glb;
  glb.add_vertices("POSITION", positions,
                   {{"componentType", unsigned_short},
                    {"type", "VEC3"},
                    {"min", {lo[0], lo[1], lo[2]}},
                    {"max", {hi[0], hi[1], hi[2]}}});
  glb.add_vertices("_INTENSITY", intensities, {{"componentType", unsigned_short}, {"type", "SCALAR"}});
  glb.add_vertices("_CLASSIFICATION", classes, {{"componentType", unsigned_byte}, {"type", "SCALAR"}});
  glb.add_vertices("_TILE", tiles, {{"componentType", real}, {"type", "SCALAR"}});
  glb.add_indices(ordered.corners, ordered.vertices.size());
  return glb.finish({{"mesh", 0},
                     {"translation", {bounds.lo.x - origin.x, bounds.lo.z - origin.z, origin.y - bounds.hi.y}},
                     {"scale", {step[0], step[2], step[1]}}});
}

}  // namespace tessera::tileset

#include "src/result/tileset/glb_file.h"

#include <meshoptimizer.h>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "src/base/json/json_text.h"

namespace tessera::tileset {
namespace {

constexpr int unsigned_byte = 5121, unsigned_short = 5123, unsigned_int = 5125, real = 5126;  // as in OpenGL
constexpr int array_buffer = 34962, element_array_buffer = 34963;
constexpr double steps = 65535;
constexpr std::size_t short_indices_max = 65535;  // vertices; index 65535 would restart a primitive

}  // namespace

template <class T>
void GlbFile::add_vertices(const char* name, const std::vector<T>& values, Json accessor) {
  meshopt_encodeVertexVersion(0);
  std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(values.size(), sizeof(T)));
  packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), values.data(), values.size(), sizeof(T)));
  attributes_[name] = accessors_.size();
  add(packed, values.size(), sizeof(T), "ATTRIBUTES", array_buffer, true, std::move(accessor));
}

void GlbFile::add_positions(std::span<const Point> positions, const Point& origin) {
  Bounds bounds;
  for (const Point& p : positions) bounds.add(p);
  double step[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double length = bounds.hi[axis] - bounds.lo[axis];
    step[axis] = length > 0 ? length / steps : 1;
  }
  // -y grows where y falls, so it is counted from the other end.
  const auto top = static_cast<std::uint16_t>(std::lround((bounds.hi.y - bounds.lo.y) / step[1]));
  std::vector<PackedPosition> packed;
  packed.reserve(positions.size());
  std::uint16_t lo[3] = {65535, 65535, 65535}, hi[3] = {0, 0, 0};
  for (const Point& p : positions) {
    std::uint16_t q[3];
    for (int axis = 0; axis < 3; ++axis)
      q[axis] = static_cast<std::uint16_t>(std::lround((p[axis] - bounds.lo[axis]) / step[axis]));
    PackedPosition& at = packed.emplace_back();
    at.at[0] = q[0];
    at.at[1] = q[2];
    at.at[2] = static_cast<std::uint16_t>(top - q[1]);
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = std::min(lo[k], at.at[k]);
      hi[k] = std::max(hi[k], at.at[k]);
    }
  }
  add_vertices("POSITION", packed,
               {{"componentType", unsigned_short},
                {"type", "VEC3"},
                {"min", {lo[0], lo[1], lo[2]}},
                {"max", {hi[0], hi[1], hi[2]}}});
  node_ = {{"mesh", 0},
           {"translation", {bounds.lo.x - origin.x, bounds.lo.z - origin.z, origin.y - bounds.hi.y}},
           {"scale", {step[0], step[2], step[1]}}};
}

void GlbFile::add_shorts(const char* name, const std::vector<PackedShort>& values) {
  add_vertices(name, values, {{"componentType", unsigned_short}, {"type", "SCALAR"}});
}
void GlbFile::add_bytes(const char* name, const std::vector<PackedByte>& values) {
  add_vertices(name, values, {{"componentType", unsigned_byte}, {"type", "SCALAR"}});
}
void GlbFile::add_floats(const char* name, const std::vector<float>& values) {
  add_vertices(name, values, {{"componentType", real}, {"type", "SCALAR"}});
}
void GlbFile::add_words(const char* name, const std::vector<std::uint32_t>& values) {
  // Little endian, as glTF and all supported machines are.
  add_vertices(name, values, {{"componentType", unsigned_short}, {"type", "VEC2"}});
}

void GlbFile::add_triangles(const std::vector<std::uint32_t>& corners, std::size_t vertices) {
  meshopt_encodeIndexVersion(1);  // required by EXT_meshopt_compression
  std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(corners.size(), vertices));
  packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), corners.data(), corners.size()));
  const bool is_short = vertices <= short_indices_max;
  add(packed, corners.size(), is_short ? 2 : 4, "TRIANGLES", element_array_buffer, false,
      {{"componentType", is_short ? unsigned_short : unsigned_int}, {"type", "SCALAR"}});
}

std::vector<std::byte> GlbFile::finish(const Json& extras) const {
  Json scene = Json::object();
  if (!extras.is_null()) scene["extras"] = extras;
  Json document{{"asset", {{"version", "2.0"}, {"generator", "tessera"}}}, {"scene", 0}};
  if (!accessors_.empty()) {
    scene["nodes"] = {0};
    const Json extensions = Json::array({"KHR_mesh_quantization", "EXT_meshopt_compression"});
    Json primitive{{"attributes", attributes_}, {"indices", accessors_.size() - 1}, {"material", 0}};
    document["extensionsUsed"] = extensions;
    document["extensionsRequired"] = extensions;
    document["nodes"] = Json::array({node_});
    document["meshes"] = Json::array({Json{{"primitives", Json::array({primitive})}}});
    document["materials"] = {
        {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}, {"doubleSided", true}}};
    document["accessors"] = accessors_;
    document["bufferViews"] = views_;
    document["buffers"] = {
        {{"byteLength", bytes_.size()}},
        // The buffer into which readers unpack.
        {{"byteLength", unpacked_}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}};
  }
  document["scenes"] = Json::array({std::move(scene)});
  std::string text = json_text(document);
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

void GlbFile::add(const std::vector<unsigned char>& packed, std::size_t count, std::size_t stride, const char* mode,
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

}  // namespace tessera::tileset

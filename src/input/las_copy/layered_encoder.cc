// Point formats 6 to 8: POINT14, RGB14, RGBNIR14 and BYTE14, in versions 3 and 4.
// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

#include "src/input/bytes/fields.h"
#include "src/input/las_copy/channel_encoder.h"
#include "src/input/las_copy/chunk_encoder.h"
#include "src/input/las_copy/returns_xy_encoder.h"

namespace tessera::laz {
namespace {

constexpr std::size_t point_bytes = 30, block_points = 4096;

class LayeredEncoder : public ChunkEncoder {
 public:
  LayeredEncoder(const LazLayout& layout, std::size_t record_bytes) : layout_(layout), record_bytes_(record_bytes) {}

  void encode(std::span<const std::byte> records) override {
    if (records.empty()) return;
    if (!xy_) {
      begin(records.first(record_bytes_));
      records = records.subspan(record_bytes_);
    }
    // Many points at once, because then the models of a layer stay in the cache.
    while (!records.empty()) {
      steps_.resize(std::min(block_points, records.size() / record_bytes_));
      xy_->encode(steps_, records.data(), record_bytes_);
      for (const auto& layer : layers_) layer->encode(steps_, records.data(), record_bytes_);
      points_ += static_cast<std::uint32_t>(steps_.size());
      records = records.subspan(steps_.size() * record_bytes_);
    }
  }

  // The first point uncompressed, the number of points, the lengths of all layers, the layers.
  std::vector<std::byte> finish() override {
    std::vector<std::byte> bytes = std::move(first_), layers = xy_->finish();
    push(bytes, points_);
    push(bytes, static_cast<std::uint32_t>(layers.size()));
    for (const auto& layer : layers_) {
      const auto stream = layer->finish();
      push(bytes, static_cast<std::uint32_t>(stream.size()));
      layers.insert(layers.end(), stream.begin(), stream.end());
    }
    bytes.insert(bytes.end(), layers.begin(), layers.end());
    return bytes;
  }

 private:
  static void push(std::vector<std::byte>& to, std::uint32_t value) {
    const auto raw = std::as_bytes(std::span(&value, 1));
    to.insert(to.end(), raw.begin(), raw.end());
  }

  void begin(std::span<const std::byte> record) {
    first_.assign(record.begin(), record.end());
    points_ = 1;
    xy_.emplace(record.data());
    add<ZEncoder>(8);
    add<ClassificationEncoder>(16);
    add<FlagsEncoder>(15);
    add<IntensityEncoder>(12);
    add<ScanAngleEncoder>(18);
    add<UserDataEncoder>(17);
    add<SourceEncoder>(20);
    add<GpsTimeLayerEncoder>(22);
    std::size_t at = point_bytes;
    const ItemType colours = layout_.items.size() > 1 ? layout_.items[1].type : ItemType::byte_14;
    if (colours == ItemType::rgb_14 || colours == ItemType::rgb_nir_14) {
      add<RgbLayerEncoder>(at, layout_.items[1].version);
      at += sizeof(Rgb);
    }
    if (colours == ItemType::rgb_nir_14) {
      add<NirLayerEncoder>(at, layout_.items[1].version);
      at += 2;
    }
    for (; at < record_bytes_; ++at) add<ByteLayerEncoder>(at, layout_.items.back().version);
  }

  // Adds the layer of the field at byte `at` of a record.
  template <class State>
  void add(std::size_t at, std::uint16_t version = 4) {
    const unsigned channel = std::to_integer<unsigned>(first_[15]) >> 4 & 3;
    layers_.push_back(std::make_unique<ChannelEncoder<State>>(load<typename State::Value>(first_.data() + at), channel,
                                                              at, version == 3));
  }

  LazLayout layout_;
  std::size_t record_bytes_;
  std::vector<std::byte> first_;
  std::uint32_t points_ = 0;
  std::optional<ReturnsXyEncoder> xy_;
  std::vector<std::unique_ptr<LayerEncoder>> layers_;
  std::vector<PointStep> steps_;
};

}  // namespace

std::unique_ptr<ChunkEncoder> make_layered_encoder(const LazLayout& layout, std::size_t record_bytes) {
  return std::make_unique<LayeredEncoder>(layout, record_bytes);
}

}  // namespace tessera::laz

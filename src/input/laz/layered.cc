// Point formats 6 to 10. Each group of fields has a stream of its own, a layer, which is read only if it is wanted. A
// layer is decoded for many points at once, because then its models stay in the cache.
// Source: LASzip, design/specification.rst; rapidlasso, LAZ Specification 1.4.
#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

#include "src/input/bytes/fields.h"
#include "src/input/laz/channel_layer.h"
#include "src/input/laz/chunk_decoder.h"
#include "src/input/laz/layer_states.h"
#include "src/input/laz/returns_xy_layer.h"

namespace tessera::laz {
namespace {

constexpr std::size_t point_bytes = 30, block_points = 4096;

class LayeredDecoder : public ChunkDecoder {
 public:
  LayeredDecoder(const ByteSource& source, const LazLayout& layout, const WantedFields& plan, const Chunk& chunk)
      : source_(source), layout_(layout), plan_(plan), chunk_(chunk) {}

  Status decode(std::size_t n, std::byte* records) override {
    if (n == 0) return success();
    const std::size_t stride = plan_.record_bytes;
    if (!xy_) {
      BOOST_OUTCOME_TRYV(begin(records));
      records += stride;
      --n;
    }
    while (n > 0) {
      const std::size_t count = std::min(n, block_points);
      steps_.resize(count);
      xy_->decode(steps_, records, stride);
      BOOST_OUTCOME_TRYV(check_stream(xy_->feed()));
      for (const auto& layer : layers_) {
        layer->decode(steps_, records, stride);
        if (const ByteFeed* feed = layer->feed()) {
          BOOST_OUTCOME_TRYV(check_stream(*feed));
        }
      }
      records += count * stride;
      n -= count;
    }
    return success();
  }

  Status check_end() const override {
    if (chunk_.points < 2) return success();  // then no stream was begun
    BOOST_OUTCOME_TRYV(check_stream_end(xy_->feed()));
    for (const auto& layer : layers_)
      if (const ByteFeed* feed = layer->feed()) {
        BOOST_OUTCOME_TRYV(check_stream_end(*feed));
      }
    return success();
  }

 private:
  // The chunk begins with its first point uncompressed, its number of points, and the lengths of all its layers.
  Status begin(std::byte* record) {
    const LazItem* const extra = layout_.find(ItemType::byte_14);
    const LazItem* const nir = layout_.find(ItemType::rgb_nir_14);
    const LazItem* const rgb = nir != nullptr ? nir : layout_.find(ItemType::rgb_14);
    const LazItem* const waves = layout_.find(ItemType::wave_packet_14);
    const std::size_t layer_count =
        9u + (rgb != nullptr) + (nir != nullptr) + (waves != nullptr) + (extra != nullptr ? extra->bytes : 0);
    const std::size_t head_bytes = plan_.record_bytes + 4 + 4 * layer_count;
    if (chunk_.end - chunk_.begin < head_bytes) return error(Errc::bad_input, "the chunk ends within its head");
    std::vector<std::byte> head(head_bytes);
    BOOST_OUTCOME_TRYV(source_.read(chunk_.begin, head));
    std::memcpy(record, head.data(), plan_.record_bytes);
    const auto* lengths = head.data() + plan_.record_bytes;
    if (const auto points = load<std::uint32_t>(lengths); points != chunk_.points)
      return error(Errc::bad_input, "the chunk says that it has " + std::to_string(points) + " points, not the " +
                                        std::to_string(chunk_.points) + " of the chunk table");
    lengths += 4;
    next_ = chunk_.begin + head_bytes;
    left_ = chunk_.end - next_;

    BOOST_OUTCOME_TRY(xy_bytes, take(lengths));
    xy_.emplace(ByteFeed(source_, xy_bytes.begin, xy_bytes.end), record);
    BOOST_OUTCOME_TRYV(add<ZState>(lengths, record, 8));
    BOOST_OUTCOME_TRYV(add<ClassificationState>(lengths, record, 16));
    BOOST_OUTCOME_TRYV(add<FlagsState>(lengths, record, 15));
    BOOST_OUTCOME_TRYV(add<IntensityState>(lengths, record, 12));
    BOOST_OUTCOME_TRYV(add<ScanAngleState>(lengths, record, 18));
    BOOST_OUTCOME_TRYV(add<UserDataState>(lengths, record, 17));
    BOOST_OUTCOME_TRYV(add<SourceState>(lengths, record, 20));
    BOOST_OUTCOME_TRYV(add<GpsTimeState>(lengths, record, 22));
    std::size_t at = point_bytes;
    if (rgb != nullptr) {
      BOOST_OUTCOME_TRYV(add<RgbState>(lengths, record, at, rgb->version));
      at += sizeof(Rgb);
    }
    if (nir != nullptr) {
      BOOST_OUTCOME_TRYV(add<NirState>(lengths, record, at, nir->version));
      at += 2;
    }
    if (waves != nullptr) {  // this layer is passed over, because no field of it is ever wanted
      BOOST_OUTCOME_TRYV(take(lengths));
      at += waves->bytes;
    }
    for (; at < plan_.record_bytes; ++at) {
      BOOST_OUTCOME_TRYV(add<ByteState>(lengths, record, at, extra->version));
    }
    return success();
  }

  struct Range {
    std::uint64_t begin, end;
  };

  // Returns the place of the layer whose length is at `lengths`, and moves `lengths` to the next length.
  Result<Range> take(const std::byte*& lengths) {
    const std::uint64_t bytes = load<std::uint32_t>(lengths);
    lengths += 4;
    if (bytes > left_) return error(Errc::bad_input, "its layers are longer than the chunk");
    next_ += bytes;
    left_ -= bytes;
    return Range{next_ - bytes, next_};
  }

  // Adds the layer of the field at byte `at` of a record, if it is wanted.
  template <class State>
  Status add(const std::byte*& lengths, const std::byte* first, std::size_t at, std::uint16_t version = 4) {
    BOOST_OUTCOME_TRY(range, take(lengths));
    using Value = typename State::Value;
    const auto begin = plan_.wanted.begin() + static_cast<std::ptrdiff_t>(at);
    const bool wanted =
        std::is_same_v<State, ZState> || std::find(begin, begin + static_cast<std::ptrdiff_t>(sizeof(Value)), true) !=
                                             begin + static_cast<std::ptrdiff_t>(sizeof(Value));
    if (!wanted) return success();
    const unsigned channel = std::to_integer<unsigned>(first[15]) >> 4 & 3;
    layers_.push_back(std::make_unique<ChannelLayer<State>>(ByteFeed(source_, range.begin, range.end),
                                                            load<Value>(first + at), channel, at, version == 3));
    return success();
  }

  const ByteSource& source_;
  LazLayout layout_;
  WantedFields plan_;
  Chunk chunk_;
  std::uint64_t next_ = 0, left_ = 0;
  std::optional<ReturnsXyLayer> xy_;
  std::vector<std::unique_ptr<Layer>> layers_;
  std::vector<PointStep> steps_;
};

}  // namespace

std::unique_ptr<ChunkDecoder> make_layered_decoder(const ByteSource& source, const LazLayout& layout,
                                                   const WantedFields& plan, const Chunk& chunk) {
  return std::make_unique<LayeredDecoder>(source, layout, plan, chunk);
}

}  // namespace tessera::laz

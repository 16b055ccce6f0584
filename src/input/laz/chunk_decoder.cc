#include "src/input/laz/chunk_decoder.h"

#include <algorithm>
#include <utility>

#include "src/input/laz/pointwise.h"

namespace tessera::laz {
namespace {

class PointwiseDecoder : public ChunkDecoder {
 public:
  PointwiseDecoder(const ByteSource& source, const LazLayout& layout, const WantedFields& plan, const Chunk& chunk)
      : source_(source), record_bytes_(plan.record_bytes), chunk_(chunk), chunked_(layout.chunked()) {
    for (const auto& item : layout.items) items_.push_back({make_point_item(item), item.bytes});
  }

  Status decode(std::size_t n, std::byte* records) override {
    if (n == 0) return success();
    if (!begun_) {
      BOOST_OUTCOME_TRYV(begin(records));
      records += record_bytes_;
      --n;
    }
    for (; n > 0; --n)
      for (const auto& item : items_) {
        item.decoder->next(decoder_, records);
        records += item.bytes;
      }
    return check_stream(decoder_.feed());
  }

  // Points that are not chunked have no known end, because other data may follow them.
  Status check_end() const override {
    return chunked_ && chunk_.points > 1 ? check_stream_end(decoder_.feed()) : success();
  }

 private:
  // The first point is stored uncompressed.
  Status begin(std::byte* record) {
    begun_ = true;
    if (chunk_.end - chunk_.begin < record_bytes_)
      return error(Errc::bad_input, "the chunk ends within its first point");
    BOOST_OUTCOME_TRYV(source_.read(chunk_.begin, std::span(record, record_bytes_)));
    for (const auto& item : items_) {
      item.decoder->first(record);
      record += item.bytes;
    }
    decoder_ = ArithmeticDecoder(ByteFeed(source_, chunk_.begin + record_bytes_, chunk_.end));
    return success();
  }

  struct Item {
    std::unique_ptr<PointItem> decoder;
    std::size_t bytes;
  };
  const ByteSource& source_;
  std::size_t record_bytes_;
  Chunk chunk_;
  bool chunked_;
  std::vector<Item> items_;
  ArithmeticDecoder decoder_;
  bool begun_ = false;
};

}  // namespace

Status check_stream(const ByteFeed& feed) {
  BOOST_OUTCOME_TRYV(feed.status());
  if (feed.missing() > 0) return error(Errc::bad_input, "its compressed bytes end before its points do");
  return success();
}

Status check_stream_end(const ByteFeed& feed) {
  if (feed.position() == feed.end()) return success();
  return error(Errc::bad_input, "its points end " + std::to_string(feed.end() - feed.position()) +
                                    " bytes before its compressed bytes do");
}

std::unique_ptr<ChunkDecoder> make_chunk_decoder(const ByteSource& source, const LazLayout& layout,
                                                 const WantedFields& plan, const Chunk& chunk) {
  if (layout.compressor == Compressor::layered_chunked) return make_layered_decoder(source, layout, plan, chunk);
  return std::make_unique<PointwiseDecoder>(source, layout, plan, chunk);
}

}  // namespace tessera::laz

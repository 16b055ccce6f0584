#include "src/input/las_copy/las_copy.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "src/base/files/output_file.h"
#include "src/input/bytes/fields.h"
#include "src/input/bytes/record_stream.h"
#include "src/input/las/las_header.h"
#include "src/input/las_copy/copc_copy.h"
#include "src/input/las_copy/las_parts.h"
#include "src/input/las_copy/laz_body.h"
#include "src/input/laz/chunk_table.h"
#include "src/input/laz/laz_layout.h"
#include "src/input/laz/laz_stream.h"

namespace tessera {
namespace {

constexpr std::string_view laszip_user = "laszip encoded", copc_user = "copc";
constexpr std::uint16_t laszip_id = 22204, copc_info_id = 1;
// LASzip's usual number, for input that has no chunks; and a bound of the memory for a chunk, where the chunks need not
// be those of the input.
constexpr std::uint32_t chunk_points_usual = 50'000, chunk_points_max = 1u << 22;

bool holds_waveforms(int point_format) {
  return point_format == 4 || point_format == 5 || point_format == 9 || point_format == 10;
}

class LasCopy {
 public:
  LasCopy(std::shared_ptr<const ByteSource> source, LasHeader header, LasParts parts, OutputFile file,
          const LasCopyOptions& options, const DimensionValues& values)
      : source_(std::move(source)),
        header_(std::move(header)),
        parts_(std::move(parts)),
        file_(std::move(file)),
        options_(options),
        values_(values),
        compress_(options.packing == LasPacking::as_input ? header_.compressed : options.packing == LasPacking::laz),
        ranges_(options.dimensions.size()) {}

  Result<std::uint64_t> run() {
    BOOST_OUTCOME_TRYV(open_records());
    BOOST_OUTCOME_TRY(change, add_dimensions(*source_, header_, parts_, options_.dimensions, options_.replace));
    change_ = std::move(change);
    BOOST_OUTCOME_TRYV(choose_layout());
    BOOST_OUTCOME_TRYV(write_begin());
    if (compress_) {
      body_.emplace(file_, layout_, change_.record_bytes, end_, std::max(1u, options_.threads));
      BOOST_OUTCOME_TRYV(body_->begin());
    }
    BOOST_OUTCOME_TRYV(copy_points());
    if (compress_) {
      BOOST_OUTCOME_TRYV(body_->finish());
      end_ = body_->end();
    }
    BOOST_OUTCOME_TRYV(write_ranges());
    BOOST_OUTCOME_TRYV(write_extended());
    BOOST_OUTCOME_TRYV(source_->check_unchanged());
    BOOST_OUTCOME_TRYV(go_on());
    BOOST_OUTCOME_TRYV(file_.commit());
    return header_.points;
  }

 private:
  Error bad(const std::string& what) const { return error(Errc::bad_input, source_->path().string() + what); }

  Status go_on() const {
    if (!options_.stop.stop_requested()) return success();
    return error(Errc::interrupted, file_.path().string() + ": interrupted; nothing was written there");
  }

  // Opens the points of the input, and lists its chunks.
  Status open_records() {
    if (header_.compressed) {
      if (header_.laszip.empty()) return bad(": is LAZ, but has no LASzip record that says how it is compressed");
      BOOST_OUTCOME_TRY(layout, laz::read_laz_layout(source_->path().string(), header_.laszip, header_.point_format,
                                                     header_.record_bytes));
      input_layout_ = std::move(layout);
    }
    if (input_layout_.compressor == laz::Compressor::none) {
      auto stream =
          std::make_unique<RecordStream>(share(source_), header_.points_at, header_.record_bytes, header_.points);
      BOOST_OUTCOME_TRYV(stream->check_size());
      records_ = std::move(stream);
      return success();
    }
    BOOST_OUTCOME_TRY(chunks, laz::read_chunk_table(*source_, input_layout_, header_.points_at, header_.points,
                                                    header_.record_bytes));
    chunks_ = std::move(chunks);
    std::erase_if(chunks_, [](const laz::Chunk& chunk) { return chunk.points == 0; });
    records_ =
        std::make_unique<laz::LazStream>(share(source_), input_layout_,
                                         laz::WantedFields{.record_bytes = header_.record_bytes,
                                                           .wanted = std::vector<bool>(header_.record_bytes, true)},
                                         chunks_, std::max(1u, options_.threads));
    return success();
  }

  // Chooses how the copy is compressed, and makes the LASzip record say so.
  Status choose_layout() {
    const auto is_laszip = [](const LasRecord& record) { return record.is(laszip_user, laszip_id); };
    if (!compress_) {
      const auto of_laz = [&](const LasRecord& record) {
        return is_laszip(record) || record.is(copc_user, copc_info_id) || record.is(copc_user, 1000);
      };
      if (header_.compressed) {
        std::erase_if(parts_.records, of_laz);
        std::erase_if(parts_.extended, of_laz);
      }
      return success();
    }
    const std::size_t extra = change_.record_bytes - standard_record_bytes(header_.point_format);
    if (extra > laz::extra_bytes_max)
      return bad(": its points would have " + std::to_string(extra) + " extra bytes; LAZ is written with at most " +
                 std::to_string(laz::extra_bytes_max));
    std::uint32_t chunk_points = input_layout_.chunked() ? input_layout_.chunk_points : chunk_points_usual;
    if (header_.copc.empty() && chunk_points != std::numeric_limits<std::uint32_t>::max())
      chunk_points = std::min(chunk_points, chunk_points_max);
    layout_ = laz::standard_layout(header_.point_format, change_.record_bytes, chunk_points);
    // Version 4, where the input has it: it differs only where points of several scanner channels alternate.
    if (header_.point_format >= 6 && input_layout_.chunked())
      for (auto& item : layout_.items) item.version = input_layout_.items.front().version;
    auto payload = laz::laszip_payload(layout_, header_.laszip);
    // The last record counts, also for the reader.
    for (auto* records : {&parts_.extended, &parts_.records}) {
      const auto found = std::find_if(records->rbegin(), records->rend(), is_laszip);
      if (found == records->rend()) continue;
      found->payload = std::move(payload);
      return success();
    }
    parts_.records.push_back(new_record(laszip_user, laszip_id, "LASzip: compression of points", std::move(payload)));
    return success();
  }

  // The header, the records of variable length, and what stands between them and the points.
  Status write_begin() {
    std::uint64_t points_at = parts_.header.size() + parts_.gap.bytes;
    for (const auto& record : parts_.records) points_at += record.bytes();
    if (points_at > std::numeric_limits<std::uint32_t>::max())
      return bad(": its variable length records would be longer than LAS permits, which is 4 GiB");
    auto& header = parts_.header;
    store_at(header, 96, static_cast<std::uint32_t>(points_at));
    store_at(header, 100, static_cast<std::uint32_t>(parts_.records.size()));
    store_at(header, 104, static_cast<std::uint8_t>(header_.point_format | (compress_ ? 0x80 : 0)));
    store_at(header, 105, change_.record_bytes);
    BOOST_OUTCOME_TRYV(file_.append(header));
    end_ = header.size();
    for (const auto& record : parts_.records) {
      if (record.is(copc_user, copc_info_id)) info_at_ = end_ + record.head.size();
      if (describes_extra_bytes(record)) described_at_ = end_ + record.head.size();
      BOOST_OUTCOME_TRYV(append_record(*source_, record, file_));
      end_ += record.bytes();
    }
    BOOST_OUTCOME_TRYV(append_from(*source_, parts_.gap, file_));
    end_ += parts_.gap.bytes;
    return success();
  }

  Status copy_points() {
    std::uint64_t next = 0;
    auto chunk = chunks_.begin();
    const std::size_t most = points_at_once(batch_points_max, change_.record_bytes);
    while (true) {
      BOOST_OUTCOME_TRYV(go_on());
      BOOST_OUTCOME_TRY(block, records_->next(most));
      const std::size_t n = block.size() / header_.record_bytes;
      if (n == 0) return success();
      BOOST_OUTCOME_TRY(records, widen(next, n, block));
      next += n;
      if (!compress_) {
        BOOST_OUTCOME_TRYV(file_.append(records));
        end_ += records.size();
        continue;
      }
      BOOST_OUTCOME_TRYV(body_->add(records));
      if (layout_.variable_chunks() && next == chunk->first + chunk->points) {
        BOOST_OUTCOME_TRYV(body_->end_chunk());
        ++chunk;
      }
    }
  }

  // The records of the copy for `n` records of the input, from rank `first` on.
  Result<std::span<const std::byte>> widen(std::uint64_t first, std::size_t n, std::span<const std::byte> block) {
    if (options_.dimensions.empty()) return block;
    numbers_.assign(n * options_.dimensions.size(), 0);
    BOOST_OUTCOME_TRYV(values_(first, numbers_));
    widened_.resize(n * change_.record_bytes);
    std::byte* to = widened_.data();
    const double* number = numbers_.data();
    for (const std::byte* from = block.data(); from != block.data() + block.size(); from += header_.record_bytes) {
      for (const auto& piece : change_.kept) to = std::copy_n(from + piece.at, piece.bytes, to);
      for (std::size_t i = 0; i < options_.dimensions.size(); ++i, ++number) {
        const auto single = static_cast<float>(*number);
        const bool is_single = options_.dimensions[i].type == AttributeType::f32;
        const auto raw = is_single ? std::as_bytes(std::span(&single, 1)) : std::as_bytes(std::span(number, 1));
        to = std::copy(raw.begin(), raw.end(), to);
        ranges_[i].add(is_single ? static_cast<double>(single) : *number);  // of the values as they are stored
      }
    }
    return std::span<const std::byte>(widened_);
  }

  // The extended records, and what says where they are.
  Status write_extended() {
    if (compress_ && header_.compressed && info_at_) {
      auto info = header_.copc;
      BOOST_OUTCOME_TRYV(laz::move_copc_hierarchy(*source_, parts_, chunks_, body_->chunks(), end_, info));
      BOOST_OUTCOME_TRYV(file_.overwrite(*info_at_, info));
    }
    std::uint64_t waveforms = 0;  // where their record begins in the copy
    const std::uint64_t begin = end_, waveforms_before = place_of_waveforms();
    for (const auto& record : parts_.extended) {
      if (record.begins_at() == waveforms_before) waveforms = end_;
      BOOST_OUTCOME_TRYV(append_record(*source_, record, file_));
      end_ += record.bytes();
    }
    if (parts_.waveforms) {
      waveforms = end_;
      BOOST_OUTCOME_TRYV(append_record(*source_, *parts_.waveforms, file_));
      end_ += parts_.waveforms->bytes();
    }
    if (waveforms != 0) store_at(parts_.header, waveforms_at, waveforms);
    const bool listed = header_.minor >= 4 && load<std::uint32_t>(parts_.header.data() + 243) != 0;
    if (listed) {
      store_at(parts_.header, 235, parts_.extended.empty() ? std::uint64_t{0} : begin);
      store_at(parts_.header, 243, static_cast<std::uint32_t>(parts_.extended.size()));
    }
    if (!listed && waveforms == 0) return success();
    return file_.overwrite(0, parts_.header);
  }

  // Where the input's header says that the record of waveforms begins, also when no point has one; 0 for none.
  std::uint64_t place_of_waveforms() const {
    if (parts_.header.size() < waveforms_at + sizeof(std::uint64_t)) return 0;
    return load<std::uint64_t>(parts_.header.data() + waveforms_at);
  }

  // Writes the ranges of the new dimensions into their descriptors, once all values are known.
  Status write_ranges() {
    if (options_.dimensions.empty()) return success();
    const LasRecord& record = describe_ranges(parts_, ranges_);
    if (record.extended()) return success();  // not written yet
    return file_.overwrite(*described_at_, *record.payload);
  }

  std::shared_ptr<const ByteSource> source_;
  LasHeader header_;
  LasParts parts_;
  OutputFile file_;
  const LasCopyOptions& options_;
  const DimensionValues& values_;
  bool compress_;

  laz::LazLayout input_layout_, layout_;
  std::vector<laz::Chunk> chunks_;  // of the input
  std::unique_ptr<RecordSource> records_;
  RecordChange change_;
  std::uint64_t end_ = 0;                      // the bytes of the copy so far
  std::optional<std::uint64_t> info_at_;       // where the copy has the payload of the COPC info record
  std::optional<std::uint64_t> described_at_;  // the same of the last record of descriptors of extra bytes
  std::optional<laz::LazBody> body_;
  std::vector<ValueRange> ranges_;  // of the new dimensions
  std::vector<double> numbers_;
  std::vector<std::byte> widened_;
};

}  // namespace

Result<std::uint64_t> copy_las(std::unique_ptr<ByteSource> source, const std::filesystem::path& to,
                               const LasCopyOptions& options, const DimensionValues& values) {
  const std::shared_ptr<const ByteSource> shared = std::move(source);
  BOOST_OUTCOME_TRY(header, read_las_header(*shared));
  const bool packs = options.packing == LasPacking::as_input ? header.compressed : options.packing == LasPacking::laz;
  if (holds_waveforms(header.point_format) && (packs || header.compressed))
    return error(Errc::bad_input, shared->path().string() + ": has points of format " +
                                      std::to_string(header.point_format) +
                                      ", which hold waveforms; these are copied only from LAS to LAS");
  BOOST_OUTCOME_TRY(parts, read_las_parts(*shared, header));
  BOOST_OUTCOME_TRY(file, OutputFile::create(to));
  return LasCopy(shared, std::move(header), std::move(parts), std::move(file), options, values).run();
}

}  // namespace tessera

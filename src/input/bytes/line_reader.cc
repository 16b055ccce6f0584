#include "src/input/bytes/line_reader.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace tessera {
namespace {

constexpr std::size_t line_bytes_max = std::size_t{1} << 20;
constexpr std::size_t usual_block_bytes = std::size_t{1} << 18;

}  // namespace

LineReader::LineReader(std::unique_ptr<ByteSource> source, std::uint64_t offset)
    : source_(std::move(source)), start_(offset), position_(offset) {
  block_.resize(static_cast<std::size_t>(std::min<std::uint64_t>(usual_block_bytes, source_->size() + 1)));
}

void LineReader::rewind() {
  position_ = start_;
  begin_ = end_ = 0;
  number_ = first_number_;
}

Error LineReader::bad_line(const std::string& what) const {
  return error(Errc::bad_input, source_->path().string() + ", line " + std::to_string(number_) + ": " + what);
}

Status LineReader::fill() {
  std::memmove(block_.data(), block_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  // A long line does not fit into half of the block.
  if (end_ > block_.size() / 2) block_.resize(2 * block_.size());
  const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(block_.size() - end_, source_->size() - position_));
  BOOST_OUTCOME_TRYV(source_->read(position_, std::as_writable_bytes(std::span(block_).subspan(end_, n))));
  position_ += n;
  end_ += n;
  return success();
}

Result<std::optional<std::string_view>> LineReader::next() {
  ++number_;
  const auto find_end = [&](std::size_t from) {
    return static_cast<const char*>(std::memchr(block_.data() + from, '\n', end_ - from));
  };
  const char* end = find_end(begin_);
  while (end == nullptr && position_ < source_->size() && end_ - begin_ <= line_bytes_max) {
    const std::size_t known = end_ - begin_;
    BOOST_OUTCOME_TRYV(fill());
    end = find_end(begin_ + known);
  }
  line_at_ = position_ - (end_ - begin_);
  if (end == nullptr && begin_ == end_ && position_ >= source_->size()) {
    BOOST_OUTCOME_TRYV(source_->check_unchanged());
    return std::optional<std::string_view>();
  }
  const char* begin = block_.data() + begin_;
  std::string_view line(begin, static_cast<std::size_t>((end != nullptr ? end : block_.data() + end_) - begin));
  if (line.size() > line_bytes_max) return bad_line("is longer than 1 MiB");
  begin_ += line.size() + (end != nullptr ? 1 : 0);
  if (line.ends_with('\r')) line.remove_suffix(1);
  if (line_at_ == 0 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
  return std::optional(line);
}

Status check_is_text(const ByteSource& source) {
  std::vector<std::byte> begin(static_cast<std::size_t>(std::min<std::uint64_t>(4096, source.size())));
  BOOST_OUTCOME_TRYV(source.read(0, begin));
  if (std::find(begin.begin(), begin.end(), std::byte{0}) == begin.end()) return success();
  return error(Errc::bad_input, source.path().string() + ": is not text: it holds zero bytes");
}

}  // namespace tessera
